"""One module for each page: what it says, as plain values for its template."""
