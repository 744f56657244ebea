"""`python -m fabgeo`: the command where its script is not on the path."""

from fabgeo.cli import main

main()
