"""Artificial arenas, laser scans, imperfect poses and maps, seeded, with the truth about every part."""
