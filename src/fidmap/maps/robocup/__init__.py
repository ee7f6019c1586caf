"""Maps in the colours of the RoboCup Rescue League: GeoTIFF, PNG or JPEG, as teams' programs and screenshots give them.

The parts: `palette` (what a colour means), `scale` (how long a metre is), `cells` (pixels to cells), `restore` (the map
under what was drawn over it), `read` and `write`.
"""
