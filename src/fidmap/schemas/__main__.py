"""`python -m fidmap.schemas` writes the generated schemas anew after a change of the file models."""

from pathlib import Path

from fidmap.schemas import generated

for name, text in generated().items():
    (Path(__file__).parent / f"{name}.schema.json").write_text(text, encoding="utf-8")
