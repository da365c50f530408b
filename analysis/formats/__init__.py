"""Every file format and every quantity, once: names, units, columns, how a file is read, checked and written.

Standard library only, so that YADE's Python reads it too. `quantities` says what a column means, `file_columns` which
file has which, the other modules read and write one format each; what cannot be used is an `InputError`, one line.

Imports from this package: `analysis.files`."""
