"""The version, alone in a file so that the build and the start of the program read it without imports."""

__version__ = "0.1.0"
