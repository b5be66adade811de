# SPDX-License-Identifier: Apache-2.0
"""A recording as MCAP, for Foxglove, PlotJuggler and others: JSON, a message an axis."""

import csv
import io
import json

from mcap.writer import Writer

from mmcs import logcols
from mmcs.view.runs import Run

FIXED = ("t_s", "lines")


class CsvWriter:
    """The CSV of web/recording.js, piece by piece, the first line first. Topics /axis/N with the
    fields as numbers, and /lines."""

    def __init__(self, first: str):
        names = next(csv.reader(io.StringIO(first)), [])
        if tuple(names[:2]) != FIXED:
            raise ValueError("not a recording: its first line must begin with t_s,lines")
        self._rows = RowsWriter(names)

    def add(self, text: str, last: bool) -> bytes:
        """Whole lines in; what of the file they made out."""
        for row in csv.reader(io.StringIO(text)):
            self._rows.add([float(row[0]), *map(int, row[1:])])
        return self._rows.take(last)


class RowsWriter:
    """Columns t_s, then lines or FIELD_AXIS; kind: of their values, as JSON schema calls it."""

    def __init__(self, names: list[str], kind: str = "integer"):
        self._topics: dict[str, list[tuple[str, int]]] = {}
        for column, name in enumerate(names[1:], 1):
            field, _, axis = name.rpartition("_")
            topic = f"/axis/{axis}" if field else f"/{name}"
            self._topics.setdefault(topic, []).append((field or name, column))
        self._out = _Taken()
        self._writer = Writer(self._out)
        self._writer.start(profile="", library="mmcs")
        self._channels = {
            topic: _channel(self._writer, topic, fields, kind)
            for topic, fields in self._topics.items()
        }

    def add(self, row: list) -> None:
        ns = round(row[0] * 1e9)
        for topic, fields in self._topics.items():
            data = json.dumps({field: row[column] for field, column in fields}).encode()
            self._writer.add_message(self._channels[topic], ns, data, ns)

    def take(self, last: bool) -> bytes:
        """What has been written since it was asked for last."""
        if last:
            self._writer.finish()
        return self._out.take()


class _Taken:
    """A stream that keeps its place, and gives away what is written."""

    def __init__(self):
        self._given, self._new = 0, bytearray()

    def write(self, data: bytes) -> int:
        self._new += data
        return len(data)

    def tell(self) -> int:
        return self._given + len(self._new)

    def flush(self) -> None:
        pass

    def take(self) -> bytes:
        data, self._new = bytes(self._new), bytearray()
        self._given += len(data)
        return data


def from_run(run: Run) -> bytes:
    """A finished run's log. Topics /axis/N with its fields."""
    names = logcols.header(run.axes)
    writer = RowsWriter(names, kind="number")
    for row in run.log:
        writer.add([float(value) for value in row])
    return writer.take(last=True)


def _channel(writer: Writer, topic: str, fields: list[tuple[str, int]], kind: str) -> int:
    properties = {field: {"type": kind} for field, _ in fields}
    schema = writer.register_schema(
        name="mmcs" + topic.replace("/", "."),
        encoding="jsonschema",
        data=json.dumps({"type": "object", "properties": properties}).encode(),
    )
    return writer.register_channel(topic=topic, message_encoding="json", schema_id=schema)
