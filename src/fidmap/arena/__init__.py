"""Arena files: the ground truth as people write it."""

from fidmap.arena.read import arena_json_schema, read_arena

__all__ = ["arena_json_schema", "read_arena"]
