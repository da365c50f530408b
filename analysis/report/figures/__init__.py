"""One module for each family of figures; `figure` keeps what was drawn, `curve_drawing` is what they share."""
