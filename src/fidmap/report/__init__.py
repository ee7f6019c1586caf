"""What people and programs get to see: JSON, drawing, page, terminal table; only `files` writes."""
