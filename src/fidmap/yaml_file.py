"""YAML files from outside: safe types only, bounded before memory is taken.

Scalars follow the core schema of YAML 1.2, not 1.1: `25e-3` is a number, and `no` and `2026-05-01` are the
words that they look like. Numbers remember how they were written, so that a part may be called 010 or 1E1.
"""

from __future__ import annotations

import hashlib
import re
from typing import Any

import yaml

try:
    from yaml import CSafeLoader as _SafeLoader
except ImportError:  # a PyYAML built without libyaml: slower, same answers
    from yaml import SafeLoader as _SafeLoader  # type: ignore[assignment]

from fidmap.model import FidmapError
from fidmap.text_file import FilePath, one_sentence, quoted, read_text

DEPTH_MAX = 20
NODES_MAX = 500_000

_TAG = "tag:yaml.org,2002:"


class WrittenInt(int):
    """A whole number that remembers its text."""

    written: str


class WrittenFloat(float):
    """A number that remembers its text."""

    written: str


class _Loader(_SafeLoader):
    """SafeLoader with the scalars of YAML 1.2's core schema."""


_Loader.yaml_implicit_resolvers = {}  # its own, or the base class would lose those of YAML 1.1


def _number(_: _Loader, node: yaml.ScalarNode) -> WrittenInt | WrittenFloat:
    """A scalar that looks like a number; one of absurd length is infinite, which every schema refuses."""
    text = str(node.value)
    number: WrittenInt | WrittenFloat
    if node.tag == _TAG + "int" and len(text) < 300:
        number = WrittenInt(text)
    else:
        number = WrittenFloat(re.sub(r"\.(inf|nan)", r"\1", text.lower()))
    number.written = text
    return number


for _name, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+", list("-+0123456789")),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", list("-+.0123456789")),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", list("-+.")),
    ("merge", r"<<", ["<"]),
):
    _Loader.add_implicit_resolver(_TAG + _name, re.compile(rf"^(?:{_pattern})$"), _first)
_Loader.add_constructor(_TAG + "int", _number)
_Loader.add_constructor(_TAG + "float", _number)


def load_yaml(path: FilePath, what: str, error: type[FidmapError]) -> tuple[dict[str, Any], str]:
    """The mapping that a YAML file holds, and the SHA-256 of its bytes.

    Args:
        path: the file.
        what: what it should be, for the error text ('an arena file').
        error: raised for every fault, with the line where there is one.
    """
    text, data = read_text(path, what, error)
    try:
        document = _parse(text)
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        line = f"line {mark.line + 1}: " if mark else ""
        raise error(one_sentence(path, [f"{line}{fault.problem or fault.context}"])) from None
    except yaml.YAMLError as fault:
        raise error(one_sentence(path, [f"not YAML: {fault}"])) from None
    if not isinstance(document, dict):
        found = "is empty" if document is None else f"holds {quoted(document)}"
        raise error(one_sentence(path, [f"{found}, expected {what}: a mapping of keys to values"]))
    if confusion := _other_kind(document, what):
        raise error(one_sentence(path, [confusion]))
    return document, hashlib.sha256(data).hexdigest()


KINDS = {  # what a file is called: the key that marks it, and where it belongs
    "an arena file": ("fidmap_arena", "give it with --arena"),
    "a profile file": ("fidmap_profile", "give it with --profile"),
    "a map_server YAML": ("image", "name it as a MAP"),
}


def _other_kind(document: dict[str, Any], what: str) -> str | None:
    """The classic slip, a file in another one's place: told as such, not by every key that is wrong."""
    if what not in KINDS or KINDS[what][0] in document:
        return None
    slips = (f"is {kind}, not {what}, so {remedy}" for kind, (key, remedy) in KINDS.items() if key in document)
    return next(slips, None)


def _parse(text: str) -> Any:
    """Bound the document by its events, which take no memory, then build it."""
    _check_events(text)
    loader = _Loader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        _check_keys(node, set())
        return loader.construct_document(node)
    finally:
        loader.dispose()


class _Weight:
    """Counts the values of a document with its aliases expanded; an anchor keeps the count of its node."""

    def __init__(self) -> None:
        self.open: list[tuple[int, str | None]] = [(0, None)]
        self.of_anchor: dict[str, int] = {}

    def add(self, count: int, anchor: str | None = None) -> None:
        """Count a finished value."""
        values, name = self.open[-1]
        self.open[-1] = (values + count, name)
        if anchor:
            self.of_anchor[anchor] = count

    def close(self) -> None:
        """A collection ends: it is a value of the one around it."""
        count, anchor = self.open.pop()
        self.add(count, anchor)


def _check_events(text: str) -> None:
    """Refuse deep nesting, tags, and aliases that expand to too much (a 'billion laughs' file)."""
    weight = _Weight()
    for event in yaml.parse(text, Loader=_Loader):
        if tag := getattr(event, "tag", None):
            raise _fault(f"tag {tag.replace(_TAG, '!!')} is not allowed, write plain values", event)
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in weight.of_anchor:
                raise _fault(f"alias '*{event.anchor}' stands before or inside what it names", event)
            weight.add(weight.of_anchor[event.anchor])
        elif isinstance(event, yaml.ScalarEvent):
            weight.add(1, event.anchor)
        elif isinstance(event, yaml.CollectionStartEvent):
            weight.open.append((1, event.anchor))
        elif isinstance(event, yaml.CollectionEndEvent):
            weight.close()
        if len(weight.open) > DEPTH_MAX:
            raise _fault(f"nested deeper than {DEPTH_MAX} levels", event)
        if weight.open[-1][0] > NODES_MAX:
            raise _fault(f"more than {NODES_MAX} values", event)


def _check_keys(node: yaml.Node, seen: set[int]) -> None:
    """Refuse a key given twice (YAML would keep the last in silence), and read every key as text."""
    if id(node) in seen or isinstance(node, yaml.ScalarNode):
        return
    seen.add(id(node))
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _check_keys(item, seen)
        return
    keys = set()
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _fault("a key must be a word", key)
        if key.value in keys:
            raise _fault(f"key '{key.value}' is given twice", key)
        keys.add(key.value)
        if key.tag != _TAG + "merge":
            key.tag = _TAG + "str"
        _check_keys(value, seen)


def _fault(problem: str, at: Any) -> yaml.MarkedYAMLError:
    """A fault at an event or a node."""
    return yaml.MarkedYAMLError(problem=problem, problem_mark=at.start_mark)
