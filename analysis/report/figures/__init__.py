"""One module for each family of figures; `gallery` keeps what was drawn, `drawing` is what they share."""
