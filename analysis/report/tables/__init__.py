"""One module for each topic: frames as tables; what a column is called and its unit follow from the registries."""
