"""A recording as a device: it returns the recorded readings and stores the torques written now."""

from __future__ import annotations

from pathlib import Path

from numpy.typing import ArrayLike

from haptics.devices.device import DeviceError, EndOfRecordingError, Reading, three_torques
from haptics.devices.recording import Recorder, Recording, load_recording, save_recording


class RecordedDevice:
    """Replays the angles of a recording; the handle does not feel what is written.

    Args:
        recording: A recording, or a file of one.
        log: Where readings and what was written are saved at closing; .csv or .npz; None for nowhere.

    Attributes:
        recording: What is replayed.
    """

    def __init__(self, recording: Recording | str | Path, log: str | Path | None = None) -> None:
        self.recording = recording if isinstance(recording, Recording) else load_recording(recording)
        self._log, self._recorder = log, Recorder()
        self._tick, self._closed = -1, False

    @property
    def time(self) -> float:
        """Time of the last reading, s; that of the first one before it is read."""
        return float(self.recording.time[max(self._tick, 0)]) if len(self.recording.time) else 0.0

    @property
    def written(self) -> Recording:
        """Readings and what was written after each of them."""
        return self._recorder.recording()

    def read(self) -> Reading:
        """The next row; see `Device`. Raises EndOfRecordingError after the last one."""
        self._require_open()
        if self._tick + 1 >= len(self.recording.time):
            raise EndOfRecordingError(f"the recording has no more than {len(self.recording.time)} ticks")
        self._tick += 1
        return Reading(self.recording.angles[self._tick].copy(), self.time)

    def write(self, torques: ArrayLike) -> None:
        """Keeps them beside the last reading; see `Device`. Before the first reading and at the end they are zero."""
        self._require_open()
        values = three_torques(torques)
        if self._tick >= 0 and len(self._recorder) <= self._tick:
            self._recorder.add(self.time, self.recording.angles[self._tick], values)
        elif values.any():
            raise DeviceError("a recording takes one write after each reading")

    def close(self) -> None:
        """Writes the log; see `Device`."""
        if not self._closed and self._log is not None:
            save_recording(self.written, self._log)
        self._closed = True

    def _require_open(self) -> None:
        if self._closed:
            raise DeviceError("the recorded device is closed")
