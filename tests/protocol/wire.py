"""Bytes, control messages, poses, headers: sections 1, 4 and 5 of docs/PROTOCOL.md."""

import math
import struct
from dataclasses import dataclass

VERSION = 15
CONTROL, POSE, KEYFRAME, RESUME = 1, 2, 3, 4  # the kind byte
POSE_AFTER, KEYFRAME_AFTER = 5, 6  # its lower three bits
TILE = 7


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

NUMBERS = {"ubyte": "B", "bool": "?", "uint": "I", "int": "i", "ulong": "Q", "long": "q", "float": "f", "double": "d"}
STRUCTS = {
    "Vec2": ["double"] * 2,
    "Vec3": ["double"] * 3,
    "CameraPose": ["double"] * 7,
    "Lens": ["double", "uint", "uint"],
    "Geodetic": ["double"] * 3,
    "Placement": ["double"] * 8 + ["uint"],
    "Epoch": ["long"] + ["uint"] * 4,
    "BaseOffset": ["uint", "uint", "int"],
    "ObjectRise": ["uint", "uint", "int"],
    "SightHit": ["double"] * 3 + ["int"],
}
TABLES = {
    "Frame": [("kind", "ubyte"), ("height_quantum_m", "double"), ("anchor", "Vec2"), ("axis_x_m", "Vec2"), ("axis_y_m", "Vec2"),
              ("map_origin_m", "Vec2"), ("latitude0_rad", "double"), ("longitude0_rad", "double"),
              ("latitude_step_rad", "double"), ("longitude_step_rad", "double"), ("semi_major_m", "double"),
              ("flattening", "double"), ("origin", "Geodetic")],
    "Shape": [(name, "uint") for name in ("roots_x", "roots_y", "root_log2", "samples_x", "samples_y", "sparse_levels")],
    "ViewRequest": [("protocol", "uint"), ("lens", "Lens"), ("tau_px", "double"), ("strategy", "ubyte"), ("predictor", "ubyte"),
                    ("keyframe_interval_us", "uint"), ("max_triangles", "uint"), ("max_bytes_per_second", "uint"),
                    ("occlusion", "bool"), ("memory_bytes", "uint"), ("tile_contents", "ubyte"), ("tile_bytes", "uint"),
                    ("longest_interval_us", "uint"), ("order", "ubyte"), ("eye_radius_m", "double")],
    "PathUpload": [("start_us", "long"), ("step_us", "uint"), ("poses", "[CameraPose]")],
    "TourRequest": [("id", "uint"), ("name", "string"), ("seconds", "double")],
    "GroundRequest": [("id", "uint"), ("positions", "[Vec2]")],
    "SightRequest": [("id", "uint"), ("ends", "[Vec3]"), ("above", "ubyte"), ("refraction", "double"), ("scene_time_us", "long")],
    "ViewshedRequest": [("id", "uint"), ("observer", "Vec2"), ("observer_m", "double"), ("target_m", "double"),
                        ("radius_m", "double"), ("cell_m", "double"), ("refraction", "double"), ("scene_time_us", "long")],
    "RequestCancel": [("id", "uint")],
    "SceneClock": [("at_us", "long"), ("scene_time_us", "long"), ("rate", "double")],
    "HeldTiles": [("tiles", "[ulong]")],
    "VerticalDatum": [("zero_surface", "ubyte"), ("name", "string"), ("geoid", "string"), ("first", "Vec2"),
                      ("step", "Vec2"), ("columns", "uint"), ("rows", "uint"), ("undulations_m", "[float]"),
                      ("max_error_m", "double")],
    "TileLayer": [("content", "ubyte"), ("coding", "ubyte"), ("width", "uint"), ("height", "uint"), ("origin", "Vec2"),
                  ("texel", "double"), ("step_m", "double"), ("attribution", "string")],
    "Model": [("rule", "ubyte"), ("halvings", "uint"), ("vertices", "uint"), ("faces", "[uint]"), ("base", "[int]"),
              ("quantum_m", "double"), ("atlas_side", "uint"), ("pose_epochs", "[uint]"), ("base_moves", "[int]")],
    "Welcome": [("protocol", "uint"), ("scene_id", "ulong"), ("title", "string"), ("crs", "string"), ("frame", "Frame"),
                ("shape", "Shape"), ("lowest", "int"), ("highest", "int"), ("corner_heights", "[int]"),
                ("centre_heights", "[int]"), ("tau_px", "double"), ("keyframe_interval_us", "uint"), ("models", "[Model]"),
                ("objects", "[Placement]"), ("occlusion", "bool"), ("memory_bytes", "uint"), ("epochs", "[Epoch]"),
                ("base_offsets", "[BaseOffset]"), ("tile_layers", "[TileLayer]"), ("tile_bytes", "uint"),
                ("longest_interval_us", "uint"), ("max_offset", "uint"),
                ("object_rises", "[ObjectRise]"), ("epoch_blend", "uint"), ("vertical", "VerticalDatum")],
    "TourReply": [("id", "uint"), ("step_us", "uint"), ("poses", "[CameraPose]")],
    "GroundReply": [("id", "uint"), ("heights_m", "[float]"), ("undulations_m", "[float]")],
    "SightReply": [("id", "uint"), ("error", "string"), ("ends", "[Vec3]"), ("hits", "[SightHit]")],
    "ViewshedReply": [("id", "uint"), ("error", "string"), ("first", "Vec2"), ("step", "Vec2"), ("columns", "uint"),
                      ("rows", "uint"), ("begin", "uint"), ("count", "uint"), ("cells", "[ubyte]")],
    "Refusal": [("message", "string")],
}
BODIES = ["ViewRequest", "PathUpload", "TourRequest", "GroundRequest", "Welcome", "TourReply", "GroundReply", "Refusal",
          "SceneClock", "HeldTiles", "SightRequest", "ViewshedRequest", "RequestCancel", "SightReply", "ViewshedReply"]
FROM_CLIENT = BODIES[:4] + ["SceneClock", "HeldTiles", "SightRequest", "ViewshedRequest", "RequestCancel"]


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
        """In a vector: of a number, a struct, or the offset of a table."""
        if kind in TABLES:
            return 4
        sizes = [struct.calcsize(NUMBERS[k]) for k in STRUCTS.get(kind, [kind])]
        return (sum(sizes) + max(sizes) - 1) // max(sizes) * max(sizes)

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


@dataclass
class Pose:
    eye: tuple
    orientation: tuple  # w, x, y, z

    def is_usable(self):
        norm2 = sum(c * c for c in self.orientation)
        return all(abs(c) <= 1e8 for c in self.eye) and abs(norm2 - 1) < 1e-3


@dataclass
class Numbers:
    """A pose in whole numbers."""
    eye: list
    left_out: int
    others: list

    def pose(self, m, n):
        q = 1.4142135623730951 * n
        others = iter(self.others)
        c, rest = [0.0] * 4, 1.0
        for i in range(4):
            if i != self.left_out:
                c[i] = next(others) / q
                rest = rest - c[i] * c[i]
        c[self.left_out] = math.sqrt(max(rest, 0.0))
        norm = math.sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3])
        pose = Pose(tuple(v / m for v in self.eye), tuple(v / norm for v in c))
        require(pose.is_usable(), "a pose that is not usable")
        return pose


def read_numbers(r):
    """An absolute pose, and whether it is marked as one that the camera has jumped to."""
    eye, byte = [r.zigzag() for _ in range(3)], r.number("B")
    return Numbers(eye, byte & 3, [r.number("h") for _ in range(3)]), byte & 4 != 0


class Bits:
    """What follows is bits."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, width):
        require(self.at + width <= 8 * len(self.data), "cut short")
        value = 0
        for i in range(width):
            value |= (self.data[self.at >> 3] >> (self.at & 7) & 1) << i
            self.at += 1
        return value

    def group(self, count, width):
        """(the numbers, the width to be remembered)"""
        if self.take(1):
            if self.take(1):
                width = self.take(5)
            else:
                width += -1 if self.take(1) else 1
        require(0 <= width <= 31, "a width that is none")
        codes = [self.take(width) for _ in range(count)]
        return [-((code + 1) >> 1) if code & 1 else code >> 1 for code in codes], width

    def rest(self):
        """The whole bytes that are left."""
        while self.at & 7:
            require(self.take(1) == 0, "bits after the last one")
        return self.data[self.at >> 3:]


def towards_zero(a, b):
    """a / b, b > 0"""
    return a // b if a >= 0 else -(-a // b)


class Poses:
    """The last three poses of a kind of message, and what is remembered of them."""

    def __init__(self):
        self.times, self.numbers = [], []  # the newest first
        self.time_width, self.eye_width, self.others_width = 17, 14, 10
        self.order = 0

    def add(self, time, numbers):
        require(abs(time) <= HORIZON, "an absurd time")
        self.times = [time, *self.times][:3]
        self.numbers = [numbers, *self.numbers][:3]

    def gap(self, i):
        return self.times[i] - self.times[i + 1]

    def possible_order(self, t):
        order = 0
        while (order < self.order and order + 1 < len(self.times) and 0 < t <= 10**7 and self.gap(order) > 0 and
               t // 8 <= self.gap(order) and
               all(abs(a - b) <= 10**9 for a, b in zip(self.numbers[order].eye, self.numbers[order + 1].eye))):
            order += 1
        return order

    def expected(self, order, t, values):
        """`values`: of each pose, the newest first."""
        x = list(zip(*values))
        if order == 0:
            return list(values[0])
        v1 = [towards_zero((c[0] - c[1]) * t, self.gap(0)) for c in x]
        if order == 1:
            return [c[0] + v for c, v in zip(x, v1)]
        v2 = [towards_zero((c[1] - c[2]) * t, self.gap(1)) for c in x]
        return [c[0] + v + (v - w) for c, v, w in zip(x, v1, v2)]

    def next(self, bits):
        """(time, numbers), not yet added"""
        require(self.times, "delta-coded after none")
        (change,), self.time_width = bits.group(1, self.time_width)
        t = change + (self.gap(0) if len(self.times) > 1 else 0)
        if bits.take(1):
            self.order = [o for o in (0, 1, 2) if o != self.order][bits.take(1)]
        order = self.possible_order(t)
        change, self.eye_width = bits.group(3, self.eye_width)
        eye = [a + b for a, b in zip(self.expected(order, t, [n.eye for n in self.numbers]), change)]
        left_out = self.numbers[0].left_out
        if bits.take(1):
            left_out = bits.take(2)
            others = [bits.take(16) - 32768 for _ in range(3)]
        else:
            while order > 0 and any(n.left_out != left_out for n in self.numbers[:order + 1]):
                order -= 1
            change, self.others_width = bits.group(3, self.others_width)
            others = [a + b for a, b in zip(self.expected(order, t, [n.others for n in self.numbers]), change)]
        require(all(-32768 <= v <= 32767 for v in others), "a component beyond 16 bits")
        return self.times[0] + t, Numbers(eye, left_out, others)


@dataclass
class PoseUpdate:
    time: int
    pose: Pose
    received_keyframe: int
    received_at: int
    has_jumped: bool


class PoseUpdates:
    """Reads the pose updates of a connection."""

    def __init__(self):
        self.poses, self.last, self.age_width = Poses(), None, 8

    def read(self, message):
        if message[0] == POSE:
            r = Reader(message[1:])
            time, (numbers, has_jumped), received, at = r.zigzag(), read_numbers(r), r.varint(), r.zigzag()
            at += time
            require(not r.rest(), "bytes after a pose update")
        else:
            time, numbers, received, at = self.after_another(Bits(message))
            has_jumped = False
        require(received < 1 << 32, "an absurd pose update")
        self.poses.add(time, numbers)
        self.last = PoseUpdate(time, numbers.pose(1000, 32767), received, at, has_jumped)
        return self.last

    def after_another(self, bits):
        bits.take(3)
        time, numbers = self.poses.next(bits)
        later = bits.take(2)
        require(later < 3, "an absurd pose update")
        if later == 2:
            (later,), _ = bits.group(1, 0)
        at = self.last.received_at
        if later != 0:
            require(later > 0, "an absurd pose update")
            (age,), self.age_width = bits.group(1, self.age_width)
            at = time - 256 * age
        require(not bits.rest(), "bytes after a pose update")
        return time, numbers, self.last.received_keyframe + later, at


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
    region_radius: float
    region_angle: float


@dataclass
class Keyframe:
    index: int
    base: int
    time: int
    view: View
    fingerprint: int
    mask: int  # which bits of the fingerprint it carries
    delta: bytes


def bits_of(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


def float_of(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


class Keyframes:
    """Reads the keyframes of a connection."""

    def __init__(self):
        self.poses, self.last, self.region_width = Poses(), None, 8

    def read(self, message):
        if message[0] == KEYFRAME:
            r = Reader(message[1:])
            index, base, time, (numbers, _) = r.varint(), r.varint(), r.zigzag(), read_numbers(r)
            lens_and_region = [r.varint(), r.varint(), *(r.number(code) for code in "dfff")]
            fingerprint, mask, delta = r.number("I"), 0xFFFFFFFF, r.rest()
        else:
            index, base, time, numbers, lens_and_region, fingerprint, mask, delta = self.after_another(Bits(message))
        self.poses.add(time, numbers)
        view = View(numbers.pose(128, 8191), *lens_and_region)
        require(0 <= base < index < 1 << 32, "an absurd keyframe")
        require(1 <= view.width <= 16384 and 1 <= view.height <= 16384 and 0.017 <= view.fov <= 2.97, "an absurd lens")
        require(0 < view.tau <= 1e9 and 0 <= view.region_radius <= 1e9 and 0 <= view.region_angle <= 1e9, "an absurd tolerance or region")
        self.last = Keyframe(index, base, time, view, fingerprint, mask, delta)
        return self.last

    def after_another(self, bits):
        bits.take(3)
        extras = bits.take(4) if bits.take(1) else 0
        time, numbers = self.poses.next(bits)
        steps = bits.group(2, 0)[0] if extras & 1 else (1, 1)
        index = self.last.index + steps[0]
        last = self.last.view
        lens = (last.width, last.height, last.fov)
        if extras & 2:
            lens = (bits.take(16), bits.take(16), struct.unpack("<d", struct.pack("<Q", bits.take(64)))[0])
        tau = float_of(bits.take(32)) if extras & 4 else last.tau
        if extras & 8:
            region = [float_of(bits.take(32)) for _ in range(2)]
        else:
            change, self.region_width = bits.group(2, self.region_width)
            upper = [(bits_of(before) >> 16) + by for before, by in zip((last.region_radius, last.region_angle), change)]
            require(all(0 <= v <= 0xFFFF for v in upper), "a region beyond 16 bits")
            region = [float_of(v << 16) for v in upper]
        shift = 8 * (index & 3)
        fingerprint = bits.take(8) << shift
        return index, index - steps[1], time, numbers, [*lens, tau, *region], fingerprint, 0xFF << shift, bits.rest()
