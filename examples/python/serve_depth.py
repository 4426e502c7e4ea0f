"""Serve depth images of another program to stonestack, as the camera of a cell.

Of a folder into which 16-bit PNG files are written (under another name first, then renamed), or of a ROS 2 topic:

  python3 serve_depth.py --port 30100 --folder FRAMES --camera 475,475,319.5,239.5 --depth-unit 0.001
  python3 serve_depth.py --port 30100 --topic /camera/depth/image_rect_raw --rectified

The cell file then has: camera: {driver: stream, stream: {address: 127.0.0.1, port: 30100}}
"""
from __future__ import annotations

import argparse
import itertools
import pathlib
import socketserver
import struct
import sys
import threading
import time
import zlib
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

FLOAT_UNIT = 0.0001  # m a count of depths that come as metres: up to 6.5 m
TIMEOUT = 10.0  # s that a client waits for a new image


class Frame(NamedTuple):
    """Counts of z along the optical axis (rows from the top, 0: none), metres a count, lens in pixels, seconds."""

    counts: npt.NDArray[np.uint16]
    unit: float
    lens: tuple[float, ...]  # fx fy cx cy
    distortion: tuple[float, ...]  # k1 k2 p1 p2 k3 of Brown and Conrady, or none
    time: float


def encode(frame: Frame, number: int) -> bytes:
    """The frame with its header (docs/formats.md, Depth frames over TCP)."""
    pixels = frame.counts.astype("<u2").tobytes()
    height, width = frame.counts.shape
    k = (*frame.distortion, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
    kind = 1 if any(k) else 0
    return struct.pack("<4s5I11dQ2I", b"SSD1", 128, width, height, kind, 0, *frame.lens, *k, frame.unit, frame.time,
                       number, len(pixels), zlib.crc32(pixels)) + pixels


class Folder:
    """Files that are newer than the request for a frame."""

    def __init__(self, path: str, lens: tuple[float, ...], unit: float) -> None:
        self.path, self.lens, self.unit = pathlib.Path(path), lens, unit

    def next_frame(self, deadline: float) -> Frame | None:
        from PIL import Image  # type: ignore[import]

        asked = time.time()
        while time.time() < deadline:
            for file in sorted(self.path.glob("*.png"), key=lambda f: f.stat().st_mtime):
                written = file.stat().st_mtime
                if written < asked:
                    continue
                try:
                    counts = np.asarray(Image.open(file))
                except OSError:  # not complete yet
                    continue
                if counts.ndim != 2 or counts.dtype.kind not in "iu" or counts.dtype.itemsize < 2:
                    raise ValueError(f"{file}: no 16-bit depth image with one channel")
                return Frame(counts.astype(np.uint16), self.unit, self.lens, (), written)
            time.sleep(0.01)
        return None


class Topic:
    """Images of a sensor_msgs/Image topic, with the lens of its camera_info."""

    def __init__(self, topic: str, rectified: bool) -> None:
        import rclpy  # type: ignore[import]
        from rclpy.qos import qos_profile_sensor_data  # type: ignore[import]
        from sensor_msgs.msg import CameraInfo, Image  # type: ignore[import]

        self.arrived = threading.Condition()
        self.image: Any = None
        self.images = 0
        self.info: Any = None
        self.rectified = rectified
        rclpy.init()
        self.node = rclpy.create_node("stonestack_depth")
        self.node.create_subscription(Image, topic, self.take_image, qos_profile_sensor_data)
        self.node.create_subscription(CameraInfo, topic.rsplit("/", 1)[0] + "/camera_info", self.take_info,
                                      qos_profile_sensor_data)
        threading.Thread(target=rclpy.spin, args=(self.node,), daemon=True).start()

    def take_image(self, image: Any) -> None:
        with self.arrived:
            self.image = image
            self.images += 1
            self.arrived.notify_all()

    def take_info(self, info: Any) -> None:
        with self.arrived:
            self.info = info
            self.arrived.notify_all()

    def next_frame(self, deadline: float) -> Frame | None:
        with self.arrived:
            # The first image to arrive may have been exposed before the request.
            wanted = self.images + 2
            if not self.arrived.wait_for(lambda: self.images >= wanted and self.info is not None,
                                         deadline - time.time()):
                return None
            image, info = self.image, self.info
        kinds = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
        if image.encoding not in kinds:
            raise ValueError(f"images are {image.encoding}: 16UC1 (mm) or 32FC1 (m) is wanted")
        dtype = np.dtype(kinds[image.encoding]).newbyteorder(">" if image.is_bigendian else "<")
        rows = np.frombuffer(bytes(image.data), np.uint8).reshape(image.height, image.step)
        z = np.ascontiguousarray(rows[:, : image.width * dtype.itemsize]).view(dtype)
        unit = 0.001
        if dtype.kind == "f":
            unit = FLOAT_UNIT
            known = np.isfinite(z) & (z > 0) & (z < 65535 * unit)
            z = np.rint(np.where(known, z, 0.0) / unit)
        k = () if self.rectified else tuple(info.d)[:5]
        stamp = image.header.stamp.sec + 1e-9 * image.header.stamp.nanosec
        return Frame(z.astype(np.uint16), unit, (info.k[0], info.k[4], info.k[2], info.k[5]), k, stamp)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--folder", help="folder into which 16-bit PNG files are written")
    source.add_argument("--topic", help="ROS 2 topic of depth images; its camera_info beside it")
    parser.add_argument("--camera", help="fx,fy,cx,cy of the files, pixels")
    parser.add_argument("--depth-unit", type=float, help="m a count of the files")
    parser.add_argument("--rectified", action="store_true", help="the topic's images have no distortion left")
    parser.add_argument("--address", default="127.0.0.1", help="to listen at (default: this machine only)")
    parser.add_argument("--port", type=int, default=0, help="to listen at (default: any that is free)")
    options = parser.parse_args()
    served: Folder | Topic
    if options.folder:
        lens = tuple(float(value) for value in (options.camera or "").split(",") if value)
        if len(lens) != 4 or not options.depth_unit or options.depth_unit <= 0:
            parser.error("--folder needs --camera fx,fy,cx,cy and --depth-unit")
        if not pathlib.Path(options.folder).is_dir():
            parser.error(f"{options.folder}: no such folder")
        served = Folder(options.folder, lens, options.depth_unit)
    else:
        served = Topic(options.topic, options.rectified)
    numbers = itertools.count(1)

    class Client(socketserver.StreamRequestHandler):
        def send_frame(self) -> None:
            frame = served.next_frame(time.time() + TIMEOUT)
            if frame is None:
                raise ValueError(f"no new depth image within {TIMEOUT:.0f} s")
            self.wfile.write(encode(frame, next(numbers)))

        def handle(self) -> None:
            try:
                for line in self.rfile:
                    if line not in (b"capture\n", b"stream\n"):
                        raise ValueError(f"a client asked for {line[:20]!r}")
                    self.send_frame()
                    while line == b"stream\n":
                        self.send_frame()
            except ValueError as problem:  # this client gets no frame, the next one may
                print(f"serve_depth: {problem}", file=sys.stderr, flush=True)
            except ConnectionError:
                pass  # it has gone

    socketserver.ThreadingTCPServer.allow_reuse_address = True
    socketserver.ThreadingTCPServer.daemon_threads = True
    with socketserver.ThreadingTCPServer((options.address, options.port), Client) as server:
        print(f"depth images at {options.address}:{server.server_address[1]}", flush=True)
        server.serve_forever()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
