"""What the schemas of our YAML files share: strict models, words and numbers, faults in plain language."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, WithJsonSchema
from pydantic_core import ErrorDetails, PydanticCustomError

from fidmap.text_file import quoted

LENGTH_MAX = 1e8
WORD_MAX = 200


class FileModel(BaseModel):
    """A piece of a file: no unknown keys, no conversions, no NaN or infinity, frozen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def word_of(value: object) -> str | None:
    """A name or id as its file wrote it (a bare `1` or `1E1` too), or None for what is no word."""
    if isinstance(value, str):
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return str(getattr(value, "written", value))
    return None


def _word(value: object) -> str:
    word = word_of(value)
    if word is None:
        raise PydanticCustomError("word", "must be a word")
    if not word:
        raise PydanticCustomError("word", "must not be empty")
    if len(word) > WORD_MAX or not word.isprintable() or word != word.strip():
        raise PydanticCustomError("word", f"must be at most {WORD_MAX} printable characters without spaces at its ends")
    return word


Word = Annotated[
    str,
    BeforeValidator(_word),
    WithJsonSchema({"type": ["string", "number"], "minLength": 1, "maxLength": WORD_MAX}),
]


def _version(value: object) -> int:
    if isinstance(value, bool) or value != 1:
        raise PydanticCustomError("version", f"must be 1, the only version so far, not {quoted(value)}")
    return 1


Version = Annotated[int, BeforeValidator(_version), WithJsonSchema({"const": 1})]
Metres = Annotated[float, Field(ge=-LENGTH_MAX, le=LENGTH_MAX)]
Length = Annotated[float, Field(ge=0, le=LENGTH_MAX)]
PositiveLength = Annotated[float, Field(gt=0, le=LENGTH_MAX)]


def faults_of(problems: ValidationError, document: Mapping[str, Any], model: type[BaseModel]) -> list[str]:
    """Every fault that pydantic found, each as 'PLACE: what is wrong'."""
    errors = problems.errors(include_url=False)
    return [f"{place(error['loc'], document)}: {_plainly(error, model)}" for error in errors]


def place(loc: Sequence[str | int], document: Mapping[str, Any]) -> str:
    """A place in a file as its reader finds it: `parts[3].x_m (part 2B)`, counted from 0."""
    text, owner, at = "", "", document
    for step in loc:
        if isinstance(step, str) and step.startswith("[") and step.endswith("]"):
            continue  # pydantic's mark for the key of a mapping
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
        try:
            at = at[step]  # type: ignore[index]
        except (KeyError, IndexError, TypeError):
            at = {}
        if isinstance(step, int) and isinstance(at, dict) and (word := word_of(at.get("id"))):
            owner = f" ({loc[0][:-1]} {word})" if isinstance(loc[0], str) else ""
    return (text or "file") + owner


def _known_keys(model: type[BaseModel], loc: Sequence[str | int]) -> list[str]:
    """The keys that the model at a place knows."""
    for step in loc[:-1]:
        if isinstance(step, str):
            named = {f.alias or name: f for name, f in model.model_fields.items()}
            found = _model_in(named[step].annotation) if step in named else None
            model = found or model
    return [field.alias or name for name, field in model.model_fields.items()]


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The file model inside `list[Row]`, `tuple[Row, ...]` or `Row | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    inner = (_model_in(argument) for argument in getattr(annotation, "__args__", ()))
    return next((found for found in inner if found), None)


_PLAIN = {
    "missing": "is missing",
    "float_type": "must be a number, not {found}",
    "int_type": "must be a whole number, not {found}",
    "bool_type": "must be true or false, not {found}",
    "string_type": "must be a word, not {found}",
    "list_type": "must be a list, not {found}",
    "tuple_type": "must be a list, not {found}",
    "dict_type": "must be a mapping, not {found}",
    "model_type": "must be a mapping, not {found}",
    "finite_number": "must be a finite number, not {found}",
    "greater_than": "must be greater than {gt:g}, not {found}",
    "greater_than_equal": "must be at least {ge:g}, not {found}",
    "less_than": "must be less than {lt:g}, not {found}",
    "less_than_equal": "must be at most {le:g}, not {found}",
    "literal_error": "must be {expected}, not {found}",
    "too_short": "must have at least {min_length}, not {actual_length}",
    "too_long": "must have at most {max_length}, not {actual_length}",
}


def _plainly(error: ErrorDetails, model: type[BaseModel]) -> str:
    """One fault in our words; pydantic's own where we have none."""
    if error["type"] == "extra_forbidden":
        return _unknown(str(error["loc"][-1]), _known_keys(model, error["loc"]))
    pattern = _PLAIN.get(error["type"])
    if pattern is None:
        return f"{error['msg']}, not {quoted(error['input'])}" if error["type"] == "word" else error["msg"]
    return pattern.format(found=quoted(error["input"]), **error.get("ctx", {}))


def _unknown(key: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(key, known, n=1)
    return f"unknown key (did you mean {close[0]}?)" if close else f"unknown key, known are {', '.join(known)}"
