"""An OAK camera, through its maker's library (DepthAI 3): colour, and depth that lies on it pixel by pixel.

Configuration: `device` (its id or its address, where there are several or it is on a network), `size`
([width, height] of the colour picture, 1280 x 720), `answer_s` (how long a picture may take, 5 s). The
camera itself straightens its pictures, by the lens that its maker has stored in it.
"""

# depthai is only there with the extra.
# pyright: reportMissingImports=false

from datetime import timedelta
from typing import Any, ClassVar

from ..driver import Place
from .folder import Shot
from .still_camera import ANSWER_S, LibrarySource, StillCamera, above_zero, picture_size

OPTIONS = ("device", "size", "answer_s")
SIZE = 1280, 720
EYES = 640, 400
"""The size at which the two eyes are compared."""
PICTURE, DEPTH = "picture", "depth"
WARM, STALE = 30, 1
"""Pictures until the exposure has found its value; old ones that are kept in between."""
MM_PER_CM = 10.0


class Oak(StillCamera):
    """Implements depth_camera@1."""

    extra: ClassVar[str | None] = "oak"

    def __init__(self, place: Place) -> None:
        config = place.config
        name = None if config.get("device") is None else str(config["device"])
        answer_s = above_zero(config.get("answer_s", ANSWER_S), "answer_s")
        self.device = OakDevice(name, picture_size(config) or SIZE, answer_s)
        super().__init__(place, self.device, OPTIONS)

    @property
    def lens(self) -> str:
        return f"OAK {self.device.id}"


class OakDevice(LibrarySource):
    """Takes the newest pictures of a camera."""

    def __init__(self, name: str | None, size: tuple[int, int], answer_s: float) -> None:
        self.address, self.size, self.answer_s = name, size, answer_s
        self.id = ""
        self.reach_mm: float | None = None
        self._pairs: Any = None

    def open(self) -> None:
        """Start it; raises OSError with the reason."""
        try:
            self._pipeline, self._pairs = self.begin()
            for _ in range(WARM):
                self._newest()
        except RuntimeError as fault:
            self.close()
            raise OSError(f"{self.name} cannot be started: {fault}") from fault

    def close(self) -> None:
        """Release it."""
        self._pairs = None
        super().close()

    def begin(self) -> tuple[Any, Any]:
        """Its pipeline, running, and the queue of pairs; raises OSError, and RuntimeError of the library."""
        import depthai as dai

        device = dai.Device(self._found(dai))
        pipeline = dai.Pipeline(device)
        first, left, right = (
            pipeline.create(dai.node.Camera).build(socket)
            for socket in (
                dai.CameraBoardSocket.CAM_A, dai.CameraBoardSocket.CAM_B, dai.CameraBoardSocket.CAM_C,
            )
        )  # fmt: skip
        picture = first.requestOutput(self.size, dai.ImgFrame.Type.BGR888i, enableUndistortion=True)
        # Of its settings the one that leaves out what is doubtful: a hole is told, a wrong depth is not.
        stereo = pipeline.create(dai.node.StereoDepth).build(
            left.requestOutput(EYES),
            right.requestOutput(EYES),
            dai.node.StereoDepth.PresetMode.ACCURACY,
        )
        stereo.setLeftRightCheck(True)
        stereo.setSubpixel(True)
        pairs = pipeline.create(dai.node.Sync)
        picture.link(pairs.inputs[PICTURE])
        if (
            device.getPlatform() == dai.Platform.RVC4
        ):  # there a node of its own lays it onto the picture
            onto = pipeline.create(dai.node.ImageAlign)
            stereo.depth.link(onto.input)
            picture.link(onto.inputAlignTo)
            onto.outputAligned.link(pairs.inputs[DEPTH])
        else:
            picture.link(stereo.inputAlignTo)
            stereo.depth.link(pairs.inputs[DEPTH])
        queue = pairs.out.createOutputQueue(maxSize=STALE, blocking=False)
        known = device.readCalibration()
        focal_px = known.getCameraIntrinsics(dai.CameraBoardSocket.CAM_B, *EYES)[0][0]
        self.reach_mm = focal_px * abs(known.getBaselineDistance()) * MM_PER_CM
        self.id = device.getDeviceId()
        pipeline.start()
        return pipeline, queue

    @property
    def name(self) -> str:
        """What gives the pictures, in messages."""
        return f"OAK {self.address}" if self.address else "the OAK camera"

    def _found(self, dai: Any) -> Any:
        if self.address is not None:  # on another network it is not found, but reached
            return dai.DeviceInfo(self.address)
        there = dai.Device.getAllAvailableDevices()
        if not there:
            raise OSError(
                "there is no OAK camera: is it plugged in? One on a network needs `device`, its address"
            )
        if len(there) > 1:
            ids = ", ".join(sorted(one.getDeviceId() for one in there))
            raise OSError(f"there are several OAK cameras: give `device`, one of {ids}")
        return there[0]

    def _newest(self) -> Any:
        import depthai as dai

        try:
            pair = self._pairs.get(timedelta(seconds=self.answer_s))
        except dai.MessageQueue.QueueException as fault:
            raise RuntimeError(str(fault)) from fault
        if pair is None:
            raise RuntimeError(f"nothing came within {self.answer_s:g} s")
        return pair

    def _read(self) -> Shot:
        import numpy as np

        from .vision.intrinsics import Intrinsics

        for _ in range(STALE):
            self._newest()
        pair = self._newest()
        picture, steps = pair[PICTURE].getCvFrame(), pair[DEPTH].getFrame()
        height, width = picture.shape[:2]
        lens = np.array(pair[PICTURE].getTransformation().getIntrinsicMatrix())
        far_mm = np.where(steps > 0, steps, np.nan).astype(np.float32)
        eye = Intrinsics(width, height, lens, np.zeros(5))
        return Shot(picture, far_mm, eye=eye, reach_mm=self.reach_mm)
