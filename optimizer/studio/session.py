"""One studio: its setting, the threads that answer it, and what all viewers are sent.

Of settings that come faster than they are solved only the newest is: `Newest` keeps no other. The solver's thread
answers it ("about"), and once no newer one came for `REST_S` settles it, proves it and says what each limit costs.
The rest comes from the other core, piece by piece, and is dropped as soon as a slider moves again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from threading import Condition, Lock, Thread
from time import monotonic
from typing import Any, Generic, TypeVar

from delta_cad.common.files import write_whole
from delta_cad.common.refusal import printable
from optimizer.codesign.hardware import Selection, ratios_of
from optimizer.problem.brief import DesignBrief
from optimizer.problem.validation import RequirementsError
from optimizer.studio import background, knobs, model, outlook, records
from optimizer.studio.background import AbandonedError, Background, StoppedError
from optimizer.studio.building import Build
from optimizer.studio.document import Document
from optimizer.studio.model import Solver
from optimizer.studio.setting import Setting, Solved, Task

REST_S = 0.25  # without a newer setting, after which one is settled
_WIDTHS_MM = (30.0, 64.0)  # of a parallelogram

T = TypeVar("T")


class Newest(Generic[T]):
    """A place for one: what is put replaces what nobody took."""

    def __init__(self) -> None:
        self._item: T | None = None
        self._changed, self._closed = Condition(), False

    def put(self, item: T) -> None:
        """Puts one in the place."""
        with self._changed:
            self._item = item
            self._changed.notify_all()

    def take(self, timeout_s: float | None = None) -> T | None:
        """Takes the one that is there, or waits for it; None where none came in time, or it is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._item is not None or self._closed, timeout_s)
            item, self._item = self._item, None
            return item

    @property
    def waiting(self) -> bool:
        """Whether one is there."""
        return self._item is not None

    @property
    def closed(self) -> bool:
        """Whether nobody takes any more."""
        return self._closed

    def close(self) -> None:
        """Ends all waiting."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()


class Session:
    """The studio behind a page.

    Args:
        document: The requirements file.
        path: Where `save` writes.
        out: Folder of the folders of machines.
        send: Sends a message to every viewer.
    """

    def __init__(
        self, document: Document, path: Path, out: Path, send: Callable[[dict[str, Any]], object], saved: bool = True
    ) -> None:
        self.document, self.path, self._send, self._saved = document, path, send, saved
        self.brief: DesignBrief = document.brief()
        self.knobs = knobs.knobs_of(self.brief)
        self.hardware = model.hardware_of(self.brief)
        self.own = self.setting = Setting(knobs.values_of(self.brief, self.knobs), self.hardware[0])
        self._touched: set[str] = set()  # of motor, drive, ratio, width and placement
        self._lock, self._wanted = Lock(), Newest[Setting]()
        self._solver, self._held = Solver(), set[tuple[Any, ...]]()
        self._kept: dict[str, dict[str, Any]] = {}  # kind of message -> the last, for viewers that come later
        self._rested = Newest[tuple[Setting, Solved | None]]()
        self._generation = 0
        self.build = Build(out, self._build_said, self._built)
        self._background: Background | None = None
        self._threads = [Thread(target=work, daemon=True) for work in (self._solve, self._look)]

    def begin(self) -> None:
        """Starts to answer."""
        self._background = Background()
        folder = self.build.out / self.brief.name
        if (folder / "assembly.glb").is_file():
            self._built(folder, new=False)
        for thread in self._threads:
            thread.start()
        self._wanted.put(self.setting)

    def close(self) -> None:
        """Ends what goes on: threads, the other process, a build."""
        self._wanted.close()
        self._rested.close()
        if self._background is not None:
            self._background.close()
        self.build.close()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(5.0)

    # What viewers send.

    def hello(self) -> list[dict[str, Any]]:
        """Gives what a new viewer needs to know."""
        low, high = ratios_of(self.brief)
        first = {
            "type": "hello",
            "name": self.brief.name,
            "file": self.path.name,
            "goal": self.brief.objective,
            "knobs": [asdict(one) for one in self.knobs],
            "motors": records.motors(self.brief),
            "ratio": {"low": low, "high": high},
            "width": {"low": _WIDTHS_MM[0], "high": _WIDTHS_MM[1]},
            "placeable": self.brief.placeable,
            "notes": list(self.brief.notes),
        }
        with self._lock:
            return [first, self._state(), *self._kept.values(), {"type": "build", **self.build.progress.record()}]

    def receive(self, message: Mapping[str, Any], viewer: str) -> None:
        """Does what a viewer wants; what it sent wrong is said to all, and changes nothing.

        Raises:
            ValueError: It is no message of this page.
        """
        kind = message.get("type")
        if kind == "set":
            self._set(message, viewer)
        elif kind == "save":
            self._save()
        elif kind == "build":
            self._begin_build()
        elif kind == "stop":
            self.build.stop()
        elif kind == "reset":
            with self._lock:
                self._touched.clear()
                self.setting = replace(self.own, rest=True)
            self._changed()
        else:
            raise ValueError("no message of this page")

    def _set(self, message: Mapping[str, Any], viewer: str) -> None:
        number, values, hardware = message.get("seq"), message.get("values", {}), message.get("hardware", {})
        if not isinstance(number, int) or not isinstance(values, dict) or not isinstance(hardware, dict):
            raise ValueError("no setting")
        try:
            with self._lock:
                now = self.setting
                own = {**now.values, **knobs.legal(self.knobs, values)}
                choice = self._chosen(now.choice, hardware)
                self.document.brief({name: value for name, value in own.items() if value != self.own.values.get(name)})
                self._touched |= hardware.keys()
                self.setting = Setting(own, choice, (viewer, number), message.get("rest") is True)
        except (RequirementsError, ValueError) as error:
            lines = error.lines if isinstance(error, RequirementsError) else [str(error)]
            self._say("error", "; ".join(map(printable, lines)), by=(viewer, number))
            return
        self._changed()

    def _chosen(self, now: Selection, hardware: Mapping[str, Any]) -> Selection:
        """The hardware with what a viewer chose of it; ValueError for what may not be chosen."""
        known = {(one["motor"], one["drive"]) for one in records.motors(self.brief)}
        motor, drive = hardware.get("motor", now.motor), hardware.get("drive", now.drive)
        if (motor, drive) not in known:
            raise ValueError("motor and drive: must be of those that the requirements allow")
        low, high = ratios_of(self.brief) if drive == "capstan" else (1.0, 1.0)
        ratio, width = hardware.get("ratio", now.ratio), hardware.get("width_mm", now.width_mm)
        for value in (ratio, width):
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise ValueError("ratio and distance of the rods: must be numbers")
        if "drive" in hardware and drive != now.drive and "ratio" not in hardware:
            ratio = math.sqrt(low * high)
        placed = hardware.get("placed", now.placed)
        return Selection(
            motor,
            drive,
            round(min(max(float(ratio), low), high), 2),
            round(min(max(float(width), _WIDTHS_MM[0]), _WIDTHS_MM[1]), 1),
            entries=now.entries if (motor, drive) == (now.motor, now.drive) else {},
            placed=placed is True and self.brief.placeable,
        )

    def _changed(self) -> None:
        self._generation += 1
        if self._background is not None:
            self._background.abandon()
        self._wanted.put(self.setting)
        self._tell(self._state())

    def _state(self) -> dict[str, Any]:
        now = self.setting
        return {
            "type": "state",
            "by": list(now.by),
            "values": dict(now.values),
            "hardware": records.hardware(now.choice),
            "saved": self._saved and not self._edits(),
        }

    # Saving and building.

    def _edits(self) -> dict[str, Any]:
        """Table and field -> value, of what the setting has and the file has not."""
        now, own = self.setting, self.own
        found: dict[str, Any] = {k: v for k, v in now.values.items() if v != own.values.get(k)}
        names = {"motor": "hardware.motor", "drive": "hardware.drive", "ratio": knobs.RATIO}
        for name, field in names.items():
            if name in self._touched and (name != "ratio" or now.choice.drive == "capstan"):
                found[field] = getattr(now.choice, name)
        if "width_mm" in self._touched:
            found["limits.parallelogram_width_mm"] = now.choice.width_mm
        if "placed" in self._touched:
            found["placement"] = "rectangle" if now.choice.placed else "symmetric"
        return found

    def text(self) -> str:
        """Writes the requirements file of the setting."""
        edits = self._edits()
        return self.document.with_values(edits) if edits else self.document.text

    def _save(self) -> None:
        """Writes the file; another one where that changed, or came to be, since it was read."""
        text, path = self.text(), self.path
        try:
            Document(text, path.name, self.document.folder, self.document.own_parts).brief()
            there = path.read_text(encoding="utf-8") if path.exists() else None
            if there is not None and (not self._saved or there != self.document.text):
                stem = self.path.stem
                path = next(
                    one for k in range(2, 1000) if not (one := self.path.with_name(f"{stem}-{k}.toml")).exists()
                )
            write_whole(path, text)
        except (RequirementsError, OSError, UnicodeError, StopIteration) as error:
            self._say("error", f"not saved: {printable(str(error))}")
            return
        other = path != self.path and self._saved
        with self._lock:
            self.path, self._saved = path, True
            self.document = replace(self.document, text=text, file=path.name)
            self.own = replace(self.setting, by=("", 0))
            self._touched.clear()
        why = " (the file had changed on the disk and stays unchanged)" if other else ""
        self._say("saved", f"saved to {path.name}{why}")
        self._tell(self._state())

    def _begin_build(self) -> None:
        if self.build.running:
            self._say("error", "a build is under way: stop it first")
            return
        try:
            text = self.text()
            Document(text, self.path.name, self.document.folder, self.document.own_parts).brief()
            own_parts = self.document.own_parts or self.brief._own_folder
            self.build.begin(text, self.brief.name, own_parts)
        except (RequirementsError, OSError) as error:
            self._say("error", f"not built: {printable(str(error))}")

    def _build_said(self) -> None:
        self._tell({"type": "build", **self.build.progress.record()}, keep=False)

    def _built(self, folder: Path, new: bool = True) -> None:
        if (found := records.solids(folder)) is not None:
            self._tell({"type": "solids", "new": new, **found})

    # What viewers are sent.

    def _tell(self, message: dict[str, Any], keep: bool = True) -> None:
        if keep and message["type"] not in ("state", "say"):
            with self._lock:
                self._kept[f"{message['type']} {message.get('name', '')}"] = message
        self._send(message)

    def _say(self, kind: str, text: str, by: tuple[str, Any] = ("", 0)) -> None:
        self._tell({"type": "say", "kind": kind, "text": text, "by": list(by)}, keep=False)

    def _doing(self, text: str) -> None:
        self._tell({"type": "doing", "text": text})

    # The solver's thread.

    def _task(self, setting: Setting) -> Task:
        changed = {name: value for name, value in setting.values.items() if value != self.own.values.get(name)}
        return Task(self.document.brief(changed) if changed else self.brief, setting.choice)

    def _solve(self) -> None:
        drawer, now = records.Drawer(), None
        while not self._wanted.closed:
            # after an answer only as long as it takes for the slider to count as at rest
            newest = self._wanted.take(None if now is None else 0.0 if now.rest else REST_S)
            if self._wanted.closed:
                return
            try:
                if newest is not None:
                    now = newest
                    self._answer(now, drawer)
                elif now is not None:
                    settled, now = now, None
                    self._settle(settled, drawer)
            except AbandonedError:
                continue  # a newer one is there
            except Exception as error:  # shown, and the page goes on: nothing that was set is lost
                self._say("error", f"not solved: {type(error).__name__}: {printable(str(error))}")
                now = None

    def _answer(self, setting: Setting, drawer: records.Drawer) -> None:
        began, task = monotonic(), self._task(setting)
        if self._solver.last is None:
            return  # the first lengths are found where it is settled
        found = self._solver.move(task)
        if found is None:
            self._tell(records.nothing(setting, "about", monotonic() - began))
            return
        self._tell(records.answer(found, setting, drawer, "about", monotonic() - began))

    def _settle(self, setting: Setting, drawer: records.Drawer) -> None:
        began, task = monotonic(), self._task(setting)

        def tick() -> None:
            if self._wanted.waiting or self._wanted.closed:
                raise AbandonedError

        if self._solver.last is None:
            self._doing("looking for the first lengths")
        found = self._solver.settle(task, tick)
        if found is None:
            self._tell(records.nothing(setting, "none", monotonic() - began))
            self._rested.put((setting, None))
            if self._solver.last is None:
                self._try_other(setting, tick)
            return
        self._publish(setting, found, drawer, began)
        self._rested.put((setting, found))

    def _publish(self, setting: Setting, found: Solved, drawer: records.Drawer, began: float) -> None:
        """Says what was proved, and then, unless a newer setting came, what the machine measures and limits cost."""
        proved = model.certify(found)
        if not proved.holds and not self._wanted.waiting:  # masses follow the lengths: once more from these
            again = self._solver.settle(found.task)
            if again is not None and (other := model.certify(again)).holds:
                found, proved = again, other
        self._tell(
            records.answer(found, setting, drawer, "proved" if proved.holds else "open", monotonic() - began, proved)
        )
        self._doing("")
        if not self._wanted.waiting:
            self._tell(records.details(found, setting, self.knobs))
            if drawer.measure(found):
                self._tell(records.answer(found, setting, drawer, "proved" if proved.holds else "open", 0.0, proved))

    def _try_other(self, setting: Setting, tick: Callable[[], None]) -> None:
        """Begins with other hardware where the first has no lengths and nobody chose any."""
        if self._touched or setting.choice != self.hardware[0]:
            return
        for choice in self.hardware[1:]:
            self._doing(f"no lengths with the first motors; trying {choice.motor} at {choice.ratio:g}:1")
            if self._solver.settle(Task(self.brief, choice), tick) is not None:
                with self._lock:
                    self.setting = self.own = replace(self.own, choice=choice)
                self._changed()
                return
        self._doing("")

    # The other core.

    def _look(self) -> None:
        while not self._rested.closed:
            rested = self._rested.take()
            if rested is None or self._background is None:
                continue
            setting, found = rested
            with suppress(AbandonedError):
                try:
                    outlook.look(_View(self, setting), found)
                except StoppedError:
                    return
                except RuntimeError as error:
                    self._say("error", f"not looked at to the end: {printable(str(error))}")
            if not self._rested.waiting:
                self._doing("")


class _View:
    """What `outlook` sees of a session: one setting, and whether it is the present one."""

    def __init__(self, session: Session, setting: Setting) -> None:
        self._session, self.setting, self._generation = session, setting, session._generation
        self.task, self.knobs, self.hardware = session._task(setting), session.knobs, session.hardware

    def compute(self, piece: Callable[..., Any], *arguments: Any) -> Any:
        """Computes a piece on the other core.

        Raises:
            AbandonedError: The setting is not the present one any more.
        """
        self.require()
        assert self._session._background is not None
        found = self._session._background.compute(piece, *arguments)
        self.require()
        return found

    def require(self) -> None:
        """Raises AbandonedError where the setting is not the present one any more."""
        if self._session._generation != self._generation or self._session._rested.closed:
            raise AbandonedError

    def doing(self, text: str) -> None:
        """Says what is being done."""
        self._session._doing(text)

    def tell(self, message: dict[str, Any]) -> None:
        """Sends a message to all viewers."""
        self._session._tell(message)

    def corrections(self, task: Task) -> Any:
        """Gives what is known of the hardware of a task."""
        return self._session._solver.corrections(task)

    def adopt(self, found: Solved | None, learnt: background.Parts | None = None) -> None:
        """Goes on from better lengths, or from what the parts ask for: the setting is settled once more."""
        session = self._session
        with session._lock:
            self.require()
            if learnt is not None and learnt.corrections is not None:
                session._solver.known[self.task.key] = learnt.corrections
                session.setting = replace(session.setting, choice=learnt.choice)
                session._held.add(session.setting.signature)
            if found is not None:
                session._solver.last = found
            session._generation += 1
            now = replace(session.setting, rest=True)
        session._wanted.put(now)
        session._tell(session._state())

    @property
    def held(self) -> bool:
        """Whether the closed forms of the parts were looked at for this setting."""
        return self.setting.signature in self._session._held

    def passed(self) -> None:
        """Notes that the closed forms of the parts ask for nothing more."""
        self._session._held.add(self.setting.signature)
