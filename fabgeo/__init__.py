"""fabgeo."""
