"""`make bench`: speeds of both codes, of stock LIGGGHTS and of a stock YADE script on one bed, in processor time."""
