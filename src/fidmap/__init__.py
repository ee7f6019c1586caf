"""fidmap scores robot maps by the fiducials drawn in them (SSRR 2011, the Fiducial Map Metric)."""

from fidmap.version import __version__

__all__ = ["__version__"]
