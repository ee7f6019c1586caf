"""`python -m fidmap`."""

from fidmap.cli import main

main()
