"""Bytes, control messages, poses, headers: sections 1, 4 and 5 of docs/PROTOCOL.md."""

import math
import struct
from dataclasses import dataclass

VERSION = 3
CONTROL, POSE, KEYFRAME, RESUME = 1, 2, 3, 4


class ProtocolError(Exception):
    """Bytes that are not of this protocol."""


def require(condition, what):
    if not condition:
        raise ProtocolError(what)


class Reader:
    """Section 1."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        require(self.at + count <= len(self.data), "cut short")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, code):
        return struct.unpack("<" + code, self.take(struct.calcsize("<" + code)))[0]

    def varint(self):
        value = 0
        for shift in range(0, 70, 7):
            byte = self.take(1)[0]
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                require(value < 1 << 64, "a varint beyond 64 bits")
                return value
        raise ProtocolError("a varint of more than ten bytes")

    def zigzag(self):
        raw = self.varint()
        return -((raw + 1) >> 1) if raw & 1 else raw >> 1

    def rest(self):
        return self.data[self.at:]


# ---- section 4: FlatBuffers, as far as they are needed

NUMBERS = {"ubyte": "B", "uint": "I", "int": "i", "ulong": "Q", "long": "q", "float": "f", "double": "d"}
STRUCTS = {
    "Vec2": ["double"] * 2,
    "Vec3": ["double"] * 3,
    "CameraPose": ["double"] * 7,
    "Lens": ["double", "uint", "uint"],
    "Geodetic": ["double"] * 3,
}
TABLES = {
    "Frame": [("kind", "ubyte"), ("height_step_m", "double"), ("anchor", "Vec2"), ("axis_x_m", "Vec2"), ("axis_y_m", "Vec2"),
              ("map_origin_m", "Vec2"), ("latitude0_rad", "double"), ("longitude0_rad", "double"),
              ("latitude_step_rad", "double"), ("longitude_step_rad", "double"), ("semi_major_m", "double"),
              ("flattening", "double"), ("origin", "Geodetic")],
    "Shape": [(name, "uint") for name in ("roots_x", "roots_y", "root_log2", "samples_x", "samples_y")],
    "ViewRequest": [("protocol", "uint"), ("lens", "Lens"), ("tau_px", "double"), ("strategy", "ubyte"), ("predictor", "ubyte"),
                    ("keyframe_interval_us", "uint"), ("max_triangles", "uint"), ("max_bytes_per_second", "uint")],
    "PathUpload": [("start_us", "long"), ("step_us", "uint"), ("poses", "[CameraPose]")],
    "TourRequest": [("id", "uint"), ("name", "string"), ("seconds", "double")],
    "GroundRequest": [("id", "uint"), ("places", "[Vec2]")],
    "Welcome": [("protocol", "uint"), ("scene_id", "ulong"), ("title", "string"), ("crs", "string"), ("frame", "Frame"),
                ("shape", "Shape"), ("lowest", "int"), ("highest", "int"), ("corner_heights", "[int]"),
                ("centre_heights", "[int]"), ("tau_px", "double"), ("keyframe_interval_us", "uint")],
    "TourReply": [("id", "uint"), ("step_us", "uint"), ("poses", "[CameraPose]")],
    "GroundReply": [("id", "uint"), ("heights_m", "[float]")],
    "Refusal": [("message", "string")],
}
BODIES = ["ViewRequest", "PathUpload", "TourRequest", "GroundRequest", "Welcome", "TourReply", "GroundReply", "Refusal"]
FROM_CLIENT = BODIES[:4]


class FlatBuffer:
    def __init__(self, data):
        self.data = data

    def number(self, kind, at):
        code = "<" + NUMBERS.get(kind, kind)
        require(0 <= at <= len(self.data) - struct.calcsize(code), "an offset beyond the message")
        return struct.unpack_from(code, self.data, at)[0]

    def follow(self, at):
        return at + self.number("I", at)

    def fields(self, table):
        """The positions of a table's fields; 0 for those that have their default."""
        vtable = table - self.number("i", table)
        count = self.number("H", vtable) // 2 - 2
        offsets = [self.number("H", vtable + 4 + 2 * i) for i in range(count)]
        return lambda i: table + offsets[i] if i < count and offsets[i] else 0

    def struct(self, name, at):
        values = []
        for kind in STRUCTS[name]:
            values.append(self.number(kind, at))
            at += struct.calcsize(NUMBERS[kind])
        return tuple(values)

    def size(self, kind):
        return sum(struct.calcsize(NUMBERS[k]) for k in STRUCTS.get(kind, [kind]))

    def value(self, kind, at):
        if kind in NUMBERS:
            return self.number(kind, at) if at else 0
        if not at:
            return None
        if kind in STRUCTS:
            return self.struct(kind, at)
        at = self.follow(at)
        if kind in TABLES:
            return self.table(kind, at)
        count = self.number("I", at)
        if kind == "string":
            require(count <= len(self.data) - at - 4, "a string beyond the message")
            return self.data[at + 4:at + 4 + count].decode("utf-8", "replace")
        item = kind.strip("[]")
        require(count * self.size(item) <= len(self.data) - at - 4, "a vector beyond the message")
        return [self.value(item, at + 4 + i * self.size(item)) for i in range(count)]

    def table(self, name, at):
        field = self.fields(at)
        return {key: self.value(kind, field(i)) for i, (key, kind) in enumerate(TABLES[name])}


def control(data):
    """(name, fields) of a control message; `data` is what follows the kind byte."""
    buffer = FlatBuffer(data)
    field = buffer.fields(buffer.follow(0))
    which = buffer.number("B", field(0)) if field(0) else 0
    require(1 <= which <= len(BODIES) and field(1), "not a message of this protocol")
    return BODIES[which - 1], buffer.table(BODIES[which - 1], buffer.follow(field(1)))


# ---- section 5

HORIZON = 1 << 60
Q = 1.4142135623730951 * 32767


@dataclass
class Pose:
    eye: tuple
    orientation: tuple  # w, x, y, z

    def is_usable(self):
        norm2 = sum(c * c for c in self.orientation)
        return all(abs(c) <= 1e8 for c in self.eye) and abs(norm2 - 1) < 1e-3


def read_pose(r):
    eye = tuple(r.zigzag() / 1000 for _ in range(3))
    left_out = r.number("B") & 3
    c, rest = [0.0] * 4, 1.0
    for i in range(4):
        if i == left_out:
            continue
        c[i] = r.number("h") / Q
        rest = rest - c[i] * c[i]
    c[left_out] = math.sqrt(max(rest, 0.0))
    norm = math.sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3])
    pose = Pose(eye, tuple(v / norm for v in c))
    require(pose.is_usable(), "a pose that is not usable")
    return pose


@dataclass
class PoseUpdate:
    time: int
    pose: Pose
    received_keyframe: int
    received_at: int


def read_pose_update(data):
    r = Reader(data)
    update = PoseUpdate(r.zigzag(), read_pose(r), r.varint(), r.zigzag())
    update.received_at += update.time
    require(r.at == len(data), "bytes after a pose update")
    require(abs(update.time) <= HORIZON and update.received_keyframe < 1 << 32, "an absurd pose update")
    return update


@dataclass
class Resume:
    scene_id: int
    keyframe: int
    time: int
    fingerprint: int
    section: bytes


def read_resume(data):
    r = Reader(data)
    resume = Resume(r.number("Q"), r.varint(), r.zigzag(), r.number("I"), r.rest())
    require(0 < resume.keyframe < 1 << 31 and abs(resume.time) <= HORIZON, "an absurd section")
    return resume


@dataclass
class View:
    pose: Pose
    width: int
    height: int
    fov: float
    tau: float
    ball: float
    turn: float


@dataclass
class Keyframe:
    index: int
    base: int
    time: int
    view: View
    fingerprint: int
    delta: bytes


def read_keyframe(data):
    r = Reader(data)
    index, base, time, pose = r.varint(), r.varint(), r.zigzag(), read_pose(r)
    view = View(pose, r.varint(), r.varint(), *(r.number(code) for code in "dfff"))
    require(base < index < 1 << 32 and abs(time) <= HORIZON, "an absurd keyframe")
    require(1 <= view.width <= 16384 and 1 <= view.height <= 16384 and 0.017 <= view.fov <= 2.97, "an absurd lens")
    require(0 < view.tau <= 1e9 and 0 <= view.ball <= 1e9 and 0 <= view.turn <= 1e9, "an absurd tolerance, ball or turn")
    return Keyframe(index, base, time, view, r.number("I"), r.rest())
