# SPDX-License-Identifier: BSD-2-Clause
"""Independent readers of CAN databases, canmatrix and cantools, behind one interface; tests use all that are there."""
import importlib.util
import os
import sys
import warnings
from dataclasses import dataclass, field

SYSTEM_PYTHON = "/usr/bin/python3"  # the one that Debian's packages are for


@dataclass
class Frame:
    name: str
    is_fd: bool
    values: dict = field(default_factory=dict)  # of the signals that are in these data
    steps: dict = field(default_factory=dict)  # of these signals: what one bit means


class Canmatrix:
    name = "canmatrix"

    def __init__(self, path):
        warnings.simplefilter("ignore")
        import canmatrix.formats

        frames = canmatrix.formats.loadp_flat(path).frames
        self.by_identifier = {frame.arbitration_id.id: frame for frame in frames}
        self.by_name = {frame.name: frame for frame in frames}

    def read(self, key, data):
        frame = self.by_identifier[key] if isinstance(key, int) else self.by_name[key]
        assert frame.size == len(data), (frame.name, frame.size, len(data))
        decoded = frame.decode(data)
        return Frame(frame.name, frame.is_fd, {name: float(value.phys_value) for name, value in decoded.items()},
                     {name: float(value.signal.factor) for name, value in decoded.items()})


class Cantools:
    name = "cantools"

    def __init__(self, path):
        import cantools

        self.database = cantools.database.load_file(path, strict=False)
        self.no_such_page = cantools.database.errors.DecodeError

    def read(self, key, data):
        message = (self.database.get_message_by_frame_id(key) if isinstance(key, int)
                   else self.database.get_message_by_name(key))
        assert message.length == len(data), (message.name, message.length, len(data))
        try:
            decoded = message.decode(data, decode_choices=False)
        except self.no_such_page:  # of the multiplexer: canmatrix gives the signals of all pages
            return None
        return Frame(message.name, message.is_fd, {name: float(value) for name, value in decoded.items()},
                     {signal.name: float(signal.scale) for signal in message.signals if signal.name in decoded})


def readers(path):
    """Those that are installed, with the database read; begins anew with Debian's Python if only that one has any."""
    there = [kind for kind in (Canmatrix, Cantools) if importlib.util.find_spec(kind.name)]
    if not there and os.path.exists(SYSTEM_PYTHON) and not os.path.samefile(sys.executable, SYSTEM_PYTHON) \
            and "FACET_TRIED" not in os.environ:
        os.environ["FACET_TRIED"] = "1"
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
    return [kind(path) for kind in there]
