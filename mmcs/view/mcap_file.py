# SPDX-License-Identifier: Apache-2.0
"""A recording as MCAP, for Foxglove, PlotJuggler and others, and back: JSON, a message an axis."""

import csv
import io
import json
import re
from collections.abc import Iterable

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import Writer

from mmcs import logcols
from mmcs.view.runs import Run

FIXED = ("t_s", "lines")


def from_csv(text: str) -> bytes:
    """The CSV of web/recording.js. Topics /axis/N with the fields as numbers, and /lines."""
    rows = csv.reader(io.StringIO(text))
    names = next(rows, [])
    if tuple(names[:2]) != FIXED:
        raise ValueError("not a recording: its first line must begin with t_s,lines")
    return from_rows(names, ([float(row[0]), *map(int, row[1:])] for row in rows))


def from_rows(names: list[str], rows: Iterable[list], kind: str = "integer") -> bytes:
    """Columns t_s, then lines or FIELD_AXIS; kind: of their values, as JSON schema calls it."""
    topics: dict[str, list[tuple[str, int]]] = {}
    for column, name in enumerate(names[1:], 1):
        field, _, axis = name.rpartition("_")
        topic = f"/axis/{axis}" if field else f"/{name}"
        topics.setdefault(topic, []).append((field or name, column))
    out = io.BytesIO()
    writer = Writer(out)
    writer.start(profile="", library="mmcs")
    channels = {topic: _channel(writer, topic, fields, kind) for topic, fields in topics.items()}
    for row in rows:
        ns = round(row[0] * 1e9)
        for topic, fields in topics.items():
            data = json.dumps({field: row[column] for field, column in fields}).encode()
            writer.add_message(channels[topic], log_time=ns, publish_time=ns, data=data)
    writer.finish()
    return out.getvalue()


def from_run(run: Run) -> bytes:
    """A finished run's log. Topics /axis/N with its fields."""
    names = logcols.header(run.axes)
    return from_rows(names, ([float(value) for value in row] for row in run.log), kind="number")


def to_csv(data: bytes) -> str:
    """The CSV of web/recording.js from such a file. Raises ValueError for any other."""
    rows: dict[int, dict[str, dict[str, int]]] = {}
    try:
        for _, channel, message in make_reader(io.BytesIO(data)).iter_messages():
            rows.setdefault(message.log_time, {})[channel.topic] = json.loads(message.data)
    except (McapError, ValueError, EOFError) as error:
        raise ValueError(f"not an MCAP file of ours, or damaged: {error}") from None
    topics = next(iter(rows.values()), {}).keys() - {"/lines"}
    if not topics or not all(re.fullmatch(r"/axis/\d{1,2}", topic) for topic in topics):
        raise ValueError("not an MCAP file of ours: its topics are not /lines and /axis/N")
    axes = sorted(topics, key=_axis)
    if any(row.keys() != {"/lines", *axes} for row in rows.values()):
        raise ValueError("a damaged MCAP file: at some sample an axis is missing")
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    first = rows[min(rows)]
    table.writerow([*FIXED, *(f"{field}_{_axis(t)}" for t in axes for field in first[t])])
    for ns, row in sorted(rows.items()):
        values = [value for topic in axes for value in row[topic].values()]
        table.writerow([f"{ns / 1e9:.9f}", row["/lines"]["lines"], *values])
    return out.getvalue()


def _axis(topic: str) -> int:
    return int(topic.rpartition("/")[2])


def _channel(writer: Writer, topic: str, fields: list[tuple[str, int]], kind: str) -> int:
    properties = {field: {"type": kind} for field, _ in fields}
    schema = writer.register_schema(
        name="mmcs" + topic.replace("/", "."),
        encoding="jsonschema",
        data=json.dumps({"type": "object", "properties": properties}).encode(),
    )
    return writer.register_channel(topic=topic, message_encoding="json", schema_id=schema)
