"""The results of a study: one SQLite file that is written as trials end, and read at any time.

Table `trials`: a row for each trial, with its number, repeat, seed, parameters, status ("done",
"failed", "timeout", "crashed"; NULL until it has run), error, versions and outcomes. Equal studies have
equal rows wherever they run. Table `log`: what differs: seconds, host, process, time, attempts, output.
Table `study`: the study's statement.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pathlib
import sqlite3
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from .design import RESERVED, Point
from .errors import StudyError, StudyStopped
from .scenes import unit_of
from .trial import Reply

try:
    import fcntl
except ImportError:  # no POSIX
    fcntl = None  # type: ignore[assignment]

FORMAT = 1
WAIT = 60.0  # seconds that a reader may hold up the writer
Column = npt.NDArray[Any]


def quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


class Lock:
    """One study at a time writes a file of results: a lock that ends with its process."""

    def __init__(self, results: pathlib.Path) -> None:
        self.path = results.with_name(results.name + ".lock")
        self.file = -1

    def __enter__(self) -> Lock:
        while fcntl is not None:
            self.file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if os.fstat(self.file).st_ino == os.stat(self.path).st_ino:
                    return self
            except FileNotFoundError:  # removed by the one before, after it was opened here
                pass
            except OSError as bad:
                os.close(self.file)
                why = f"cannot be locked: {bad.strerror}; give another file"
                if isinstance(bad, BlockingIOError):
                    why = "another study writes it now; wait, or give another file"
                raise StudyError(f"{self.path.name[:-5]}: {why}") from None
            os.close(self.file)
        return self

    def __exit__(self, *_: object) -> None:
        if self.file < 0:
            return
        with contextlib.suppress(OSError):  # someone removed it; what the study raises counts
            if os.fstat(self.file).st_ino == os.stat(self.path).st_ino:  # else it is another study's
                os.unlink(self.path)
        os.close(self.file)


def differences(then: Mapping[str, Any], now: Mapping[str, Any], path: str = "") -> list[str]:
    """Names of what differs between two statements of a study."""
    out: list[str] = []
    for key in sorted({*then, *now}):
        a, b = then.get(key), now.get(key)
        if isinstance(a, Mapping) and isinstance(b, Mapping):
            out += differences(a, b, f"{path}{key}.")
        elif a != b:
            out.append(path + key)
    return out


class Results:
    """The file of a study's results, read while it is written or later."""

    def __init__(self, file: Union[str, "os.PathLike[str]"]) -> None:
        """Raises StudyError where there is none, or another kind of file."""
        self.path = pathlib.Path(file)
        if self.path.is_dir():
            raise StudyError(f"results: '{file}' is a folder; give the file in it")
        if not self.path.is_file():
            raise StudyError(f"no results '{file}'; run the study first")
        self.database = connect(self.path)
        try:
            self.statement: dict[str, Any] = json.loads(self.one("SELECT value FROM study WHERE key = 'statement'"))
        except (sqlite3.Error, TypeError, ValueError):
            self.database.close()
            raise StudyError(f"'{file}': holds no results of a study; give another file") from None

    def one(self, query: str) -> Any:
        row = self.database.execute(query).fetchone()
        return None if row is None else row[0]

    def close(self) -> None:
        """Closes the file; it opens again with Results(file)."""
        self.database.close()

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __len__(self) -> int:
        """Trials, done or not."""
        return int(self.one("SELECT count(*) FROM trials"))

    @property
    def counts(self) -> dict[str, int]:
        """Trials by status; those that have not run as "open"."""
        rows = self.database.execute("SELECT ifnull(status, 'open'), count(*) FROM trials GROUP BY 1 ORDER BY 1")
        return {str(status): int(n) for status, n in rows}

    @property
    def names(self) -> list[str]:
        """Of the columns of `trials`."""
        return [row[1] for row in self.database.execute("PRAGMA table_info(trials)")]

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters."""
        return list(self.statement["names"])

    @property
    def outcomes(self) -> list[str]:
        """Names of the outcomes so far."""
        taken = {*RESERVED, *self.parameters}
        return [name for name in self.names if name not in taken]

    @property
    def varied(self) -> list[str]:
        """Parameters that have more than one value."""
        several = ", ".join(f"count(DISTINCT {quoted(name)}) > 1" for name in self.parameters)
        row = self.database.execute(f"SELECT {several} FROM trials").fetchone() if several else ()
        return [name for name, many in zip(self.parameters, row) if many]

    def rows(self, status: Optional[str] = "done") -> list[dict[str, Any]]:
        """Trials as dicts, by number. status: of those wanted; none: of all."""
        where = "" if status is None else "WHERE status = ?"
        cursor = self.database.execute(
            f"SELECT * FROM trials {where} ORDER BY number", () if status is None else (status,)
        )
        names = [column[0] for column in cursor.description]
        return [dict(zip(names, row)) for row in cursor]

    def columns(self, status: Optional[str] = "done") -> dict[str, Column]:
        """Columns by name: arrays (n,) of float, NaN where there is no value; of objects where a value is text."""
        rows = self.rows(status)
        out: dict[str, Column] = {}
        for name in self.names:
            values = [row[name] for row in rows]
            if any(isinstance(v, str) for v in values):
                out[name] = np.array(values, object)
            else:
                out[name] = np.array([np.nan if v is None else v for v in values], float)
        return out

    def unit(self, name: str) -> str:
        """Of a column: as the study states it, of a scene's settings and measures as they are, or ""."""
        stated: dict[str, str] = json.loads(self.one("SELECT value FROM study WHERE key = 'units'"))
        return stated.get(name) or (unit_of(name) if "scene" in self.statement else "")

    def output(self, number: int) -> str:
        """The end of what a trial wrote: messages, and where it failed."""
        row = self.database.execute("SELECT output FROM log WHERE number = ?", (int(number),)).fetchone()
        return str(row[0]) if row else ""

    def digest(self) -> str:
        """Of all rows, to the bit: studies that are equal have equal ones, wherever they ran."""
        whole = hashlib.sha256()
        for row in self.rows(None):
            cells = [f"{name}={value!r}" for name, value in sorted(row.items()) if value is not None]
            whole.update("\t".join(cells).encode() + b"\n")
        return whole.hexdigest()


def connect(path: pathlib.Path) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=WAIT, isolation_level=None)


class Recorder:
    """Writes the results of a study; made with the lock held."""

    def __init__(
        self, path: pathlib.Path, statement: Mapping[str, Any], points: Sequence[Point], units: Mapping[str, str]
    ) -> None:
        """Starts the file, or goes on with it. Raises StudyError where it is of another study."""
        self.path = path
        if path.exists() and path.stat().st_size:
            with Results(path) as old:
                other = differences(old.statement, statement)
                if other:
                    raise StudyError(
                        f"{path}: its study differs in {', '.join(other[:4])}; give another file, or remove it"
                    )
        self.database = connect(path)
        try:
            self.database.execute("BEGIN IMMEDIATE")
            self.start(statement, points)
            self.database.execute("INSERT OR REPLACE INTO study VALUES ('units', ?)", [json.dumps(dict(units))])
            self.database.execute("COMMIT")
        except sqlite3.DatabaseError as bad:
            self.database.close()
            raise StudyError(f"{path}: {bad}; give another file of results") from None
        self.known = {row[1] for row in self.database.execute("PRAGMA table_info(trials)")}

    def start(self, statement: Mapping[str, Any], points: Sequence[Point]) -> None:
        if self.database.execute("SELECT 1 FROM sqlite_master WHERE name = 'trials'").fetchone():
            return
        names = list(statement["names"])
        columns = ["number INTEGER PRIMARY KEY", "repeat INTEGER", "seed INTEGER", *map(quoted, names)]
        columns += ["status TEXT", "error TEXT", "versions TEXT"]
        self.database.execute("CREATE TABLE study (key TEXT PRIMARY KEY, value)")
        self.database.execute(f"CREATE TABLE trials ({', '.join(columns)})")
        self.database.execute(
            "CREATE TABLE log (number INTEGER PRIMARY KEY, seconds REAL, host TEXT, process INTEGER, "
            "ended TEXT, attempts INTEGER, output TEXT)"
        )
        kept = {"format": FORMAT, "statement": json.dumps(statement)}
        self.database.executemany("INSERT INTO study VALUES (?, ?)", kept.items())
        marks = ", ".join("?" * (3 + len(names)))
        self.database.executemany(
            f"INSERT INTO trials (number, repeat, seed{''.join(', ' + quoted(n) for n in names)}) VALUES ({marks})",
            ([p.number, p.repeat, p.seed, *(p.parameters[n] for n in names)] for p in points),
        )

    def open(self, again: bool) -> set[int]:
        """Numbers of the trials that are to run; again: those that failed, too."""
        if again:
            self.database.execute("BEGIN IMMEDIATE")
            cleared = sorted(self.known - {"number", "repeat", "seed"} - set(self.parameters()))
            empty = ", ".join(f"{quoted(name)} = NULL" for name in cleared)
            self.database.execute(f"UPDATE trials SET {empty} WHERE status != 'done'")
            self.database.execute("COMMIT")
        return {n for n, in self.database.execute("SELECT number FROM trials WHERE status IS NULL")}

    def parameters(self) -> list[str]:
        text = self.database.execute("SELECT value FROM study WHERE key = 'statement'").fetchone()[0]
        return list(json.loads(text)["names"])

    def record(self, replies: Sequence[tuple[Reply, int]]) -> None:
        """Writes trials that have ended, with how often each was tried, all of them or none."""
        try:
            self.database.execute("BEGIN IMMEDIATE")
            for reply, attempts in replies:
                self.record_one(reply, attempts)
            self.database.execute("COMMIT")
        except sqlite3.Error as bad:
            raise StudyStopped(f"{self.path}: cannot be written: {bad}; mend that and run the study again") from bad

    def record_one(self, reply: Reply, attempts: int) -> None:
        for name in reply.outcomes:
            if name not in self.known:
                self.database.execute(f"ALTER TABLE trials ADD COLUMN {quoted(name)}")
                self.known.add(name)
        row = {
            "status": reply.status,
            "error": reply.error or None,
            "versions": reply.versions or None,
            **reply.outcomes,
        }
        setting = ", ".join(f"{quoted(name)} = ?" for name in row)
        done = self.database.execute(
            f"UPDATE trials SET {setting} WHERE number = ? AND status IS NULL", [*row.values(), reply.number]
        )
        if done.rowcount == 1:
            self.database.execute(
                "INSERT OR REPLACE INTO log VALUES (?, ?, ?, ?, strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?, ?)",
                [reply.number, reply.seconds, reply.host, reply.process, attempts, reply.output],
            )

    def close(self) -> None:
        self.database.close()
