# SPDX-License-Identifier: Apache-2.0
"""Strict models, field types that say what they allow, and the one-line form of a mistake."""

import typing
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic_core import PydanticCustomError

from mmcs.errors import Mistake, show, suggest


class Strict(BaseModel):
    """No unknown keys, no silent conversions, no infinities."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, defer_build=True)


def refuse(allowed: str) -> PydanticCustomError:
    return PydanticCustomError("allowed", "{allowed}", {"allowed": allowed})


def is_number(value: Any) -> bool:
    # also no whole number that is beyond a float
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e308


def _number_or_list(value: Any) -> Any:
    if is_number(value):
        return float(value)
    if isinstance(value, list) and value and all(is_number(v) for v in value):
        return [float(v) for v in value]
    raise refuse("must be a number, or a list with one number per axis")


def _axes(value: Any) -> Any:
    if value == "all":
        return value
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return [value]
    whole = isinstance(value, list) and value
    if whole and all(isinstance(v, int) and not isinstance(v, bool) and v >= 0 for v in value):
        if len(set(value)) != len(value):
            raise refuse("must not name an axis twice")
        return value
    raise refuse('must be an axis number from 0, a list of them, or "all"')


def _pair(value: Any) -> Any:
    if isinstance(value, list) and len(value) == 2 and all(is_number(v) for v in value):
        if value[0] > value[1]:
            raise refuse("must be [low, high] with low <= high")
        return [float(v) for v in value]
    raise refuse("must be a pair [low, high]")


def _limit(value: Any) -> Any:
    if is_number(value):
        if value < 0:
            raise refuse("must be 0 or more (the largest magnitude), or a pair [low, high]")
        return [-float(value), float(value)]
    return _pair(value)


def _each(band):
    def check(value: Any) -> Any:
        many = isinstance(value, list) and value and all(isinstance(v, list) for v in value)
        return [band(v) for v in value] if many else band(value)

    return check


def _count(value: Any) -> Any:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return [float(value), float(value)]
    if isinstance(value, list):
        return _pair(value)
    raise refuse("must be a whole number from 0, or a pair [low, high]")


NumberOrList = Annotated[float | list[float], BeforeValidator(_number_or_list)]
Axes = Annotated[Literal["all"] | list[int], BeforeValidator(_axes)]
# Of all axes named, or a list with one for each.
Pair = Annotated[list, BeforeValidator(_each(_pair))]
Limit = Annotated[list, BeforeValidator(_each(_limit))]  # n means -n..n
Count = Annotated[list[float], BeforeValidator(_count)]  # n means exactly n

_TYPE_WORDS = {
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "float_type": "must be a number",
    "finite_number": "must be a finite number",
    "string_type": "must be a string in quotes",
    "bool_type": "must be true or false",
    "list_type": "must be a list [...]",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "union_tag_not_found": 'needs a key "kind"',
}
_BOUND_WORDS = {
    "greater_than": ("gt", "must be more than {}"),
    "greater_than_equal": ("ge", "must be at least {}"),
    "less_than": ("lt", "must be less than {}"),
    "less_than_equal": ("le", "must be at most {}"),
    "multiple_of": ("multiple_of", "must be a multiple of {}"),
    "too_short": ("min_length", "must have at least {} entries"),
    "too_long": ("max_length", "must have at most {} entries"),
    "string_too_short": ("min_length", "must have at least {} characters"),
}


def validate(model: type[Strict], data: dict, file: str) -> tuple[Any, list[Mistake]]:
    """The model made from data, or None and every mistake."""
    try:
        return model.model_validate(data), []
    except ValidationError as error:
        errors = error.errors(include_url=False)
        errors.sort(key=lambda e: e["type"] != "extra_forbidden")  # a typo also makes a key missing
        return None, [_mistake(model, data, e, file) for e in errors]


def _mistake(model: type, data: dict, error: Any, file: str) -> Mistake:
    kind, loc, ctx = error["type"], list(error["loc"]), error.get("ctx", {})
    key = ".".join(str(part) for part in _toml_path(data, loc))
    value = show(error["input"])
    if kind == "missing":
        parent = _model_at(model, loc[:-1])
        return Mistake(file, key, None, "is missing" + _meaning(parent, loc[-1]))
    if kind == "extra_forbidden":
        names = list(_keys(_model_at(model, loc[:-1])))
        hint = suggest(str(loc[-1]), names) or "; allowed: " + ", ".join(names)
        return Mistake(file, key, None, "unknown key" + hint)
    if kind in ("literal_error", "union_tag_invalid"):
        expected = str(ctx.get("expected") or ctx.get("expected_tags"))
        words = expected.replace("'", '"').replace(" or ", ", ")
        words = words.replace("False", "false").replace("True", "true")  # as TOML has them
        if kind == "union_tag_invalid":
            key, value = f"{key}.kind", show(error["input"].get("kind"))
        bare = [w.strip().strip('"') for w in words.split(",")]
        hint = suggest(value.strip('"'), bare) if value.startswith('"') else ""
        return Mistake(file, key, value, f"must be one of {words}{hint}")
    if kind in _BOUND_WORDS:
        name, text = _BOUND_WORDS[kind]
        value = value if name not in ("min_length", "max_length") else None
        return Mistake(file, key, value, text.format(f"{ctx[name]:.12g}"))
    if kind == "union_tag_not_found":
        return Mistake(file, key, None, _TYPE_WORDS[kind])
    return Mistake(file, key, value, _TYPE_WORDS.get(kind, error["msg"]))


def _toml_path(data: Any, loc: list) -> list:
    """The location without the names of union members, which no TOML file contains."""
    path = []
    for i, part in enumerate(loc):
        tag = i > 0 and isinstance(loc[i - 1], int) and isinstance(part, str)
        if tag and isinstance(data, dict) and data.get("kind") == part:
            continue
        path.append(part)
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            data = None
    return path


def _keys(model: type | None):
    return [] if model is None else list(model.model_fields)


def _meaning(model: type | None, key: str) -> str:
    field = model.model_fields.get(key) if model is not None else None
    return f"; {field.description}" if field and field.description else ""


def _model_at(model: type | None, loc: list) -> type | None:
    """The model that a location leads to, through lists, optionals and tagged unions."""
    current: Any = model
    for before, part in zip([None, *loc], loc, strict=False):
        if isinstance(part, int):
            continue
        options = _models_in(current)
        # behind an index a kind, which may also be a key
        tagged = [o for o in options if isinstance(before, int) and part in _tags(o)]
        fields = [o.model_fields[part].annotation for o in options if part in _keys(o)]
        current = (tagged or fields or [None])[0]
    options = _models_in(current)
    return options[0] if options else None


def _tags(model: type) -> tuple:
    field = model.model_fields.get("kind")
    return typing.get_args(field.annotation) if field else ()


def _models_in(annotation: Any) -> list[type]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    found = []
    for arg in typing.get_args(annotation):
        found += _models_in(arg)
    return found
