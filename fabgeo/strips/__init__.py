"""The strip model and what is constructed on it in closed form."""
