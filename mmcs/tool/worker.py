# SPDX-License-Identifier: Apache-2.0
"""A process that answers one page: the designer, the grader of the lab sheets.

One JSON object a line, in on standard input, out on standard output. {"id", "op", ...} is answered
by the method do_OP, whose reply has the request's id; what is wrong is {"id", "error"}.
"""

import json
import os
import queue
import sys
import threading
import time
import traceback

from mmcs.errors import InputError, RunError

OUT_OF_PROPORTION = "a number is out of all proportion"


class Worker:
    known: tuple[type[Exception], ...] = ()  # whose text is a sentence for people

    def __init__(self, out=sys.stdout):
        self.out = out
        self.heard = time.monotonic()  # from the page
        self.gone = threading.Event()

    def say(self, message: dict) -> None:
        self.out.write(json.dumps(message, allow_nan=False) + "\n")
        self.out.flush()

    def run(self, lines) -> None:
        """Requests one after another; `alive` at once, also in the midst of an experiment."""
        waiting: queue.Queue[dict | None] = queue.Queue()

        def listen() -> None:
            for line in lines:
                self.heard = time.monotonic()
                message = _parsed(line)
                if message.get("op") != "alive":
                    waiting.put(message)
            self.gone.set()
            waiting.put(None)

        threading.Thread(target=listen, daemon=True).start()
        while (message := waiting.get()) is not None:
            reply = {"id": message.get("id"), **self.answer(message)}
            try:
                self.say(reply)
            except ValueError:  # NaN and infinity are no JSON
                self.say({"id": message.get("id"), "error": OUT_OF_PROPORTION})

    def answer(self, message: dict) -> dict:
        op = message.get("op")
        serve = getattr(self, f"do_{op}", None) if isinstance(op, str) else None
        if serve is None:
            return {"error": f"there is no {op!r}" if isinstance(op, str) else "op: a text"}
        try:
            return serve(message)
        except (*self.known, InputError, OSError, RunError, ValueError) as error:
            return {"error": getattr(error, "strerror", None) or str(error)}
        except (KeyError, TypeError) as error:
            return {"error": f"{message['op']}: {error} is missing or of the wrong kind"}
        except (OverflowError, ZeroDivisionError):
            return {"error": OUT_OF_PROPORTION}
        except Exception as error:  # a mistake of ours: the page must not wait for ever
            traceback.print_exc()
            return {"error": f"{message['op']}: {type(error).__name__}: {error}"}


def _parsed(line: str) -> dict:
    """An object with an id that can be told again; {} for a line that is none."""
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    if not isinstance(message, dict) or not isinstance(message.get("id"), int | str | None):
        return {}
    return message


def work(worker: Worker) -> None:
    """Serves standard input and output until the page is gone."""
    try:
        worker.run(sys.stdin)
    except BrokenPipeError:
        os._exit(0)  # the page's server was gone first: nobody is left who reads
