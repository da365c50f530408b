// LIGGGHTS generates this list of its templates when it is built, and does not ship it. None are instantiated here.
