"""Finds scanned stones, plans stable towers and walls and builds them with a robot arm.

Poses are 4 x 4 matrices; `T_A_B` maps B-coordinates to A. Frames: W world (z up, table at z = 0), C camera
(optical, z forward), O stone, T tool tip. Metres, radians, kilograms, seconds. Arrays are copies.

Functions take the options of the command by name, `options={"search.friction": 0.3}`, and read its option files
and environment variables as the command does. The numbers are the command's. Ctrl-C ends a call on the main
thread with KeyboardInterrupt.
"""

from os import PathLike
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Options = Mapping[str, Union[str, int, float, bool]]
PoseLike = Union[str, NDArray[Any]]
CatalogueLike = Union["Catalogue", str, "PathLike[str]", None]
Names = Union[str, Sequence[str], None]
WallLike = Union[str, "PathLike[str]", None]

__version__: str

class Error(Exception):
    """Base of the errors of this library."""
    exit_code: int

class InvalidArgument(Error, ValueError):
    """An argument that cannot be; the message carries the values."""

class FileError(Error, OSError):
    """A file that is missing or does not hold what it should."""

class DeviceError(Error):
    """A device that does not answer or refuses."""

class Interrupted(Error):
    """Work that was ended from outside."""

class Mesh:
    """Triangles over shared vertices."""
    @property
    def vertices(self) -> Floats:
        """N x 3."""
    @property
    def faces(self) -> NDArray[np.int32]:
        """N x 3, counter-clockwise seen from outside."""

class Stone:
    """Model of a scanned stone, in its frame O."""
    @property
    def name(self) -> str: ...
    @property
    def mesh(self) -> Mesh:
        """At most 500 faces."""
    @property
    def scan(self) -> Mesh:
        """Full resolution."""
    @property
    def pieces(self) -> list[Mesh]:
        """Convex pieces."""
    @property
    def friction(self) -> float: ...
    @property
    def density(self) -> float: ...
    @property
    def source(self) -> str: ...
    @property
    def mass(self) -> float: ...
    @property
    def p_O_M(self) -> Floats:
        """Centre of mass, 3."""
    @property
    def I_M(self) -> Floats:
        """Inertia about the centre of mass, 3 x 3."""
    @property
    def T_O_file(self) -> Floats: ...

class Catalogue:
    """Stones of a folder, sorted by name."""
    @property
    def path(self) -> str: ...
    @property
    def names(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, key: Union[str, int]) -> Stone: ...

def read_catalogue(path: CatalogueLike = None) -> Catalogue:
    """Stones of a folder; None: the six that come with stonestack."""

class DepthInput:
    """What a depth image, a recording or a cloud does not contain."""
    def __init__(self, *, unit: float = 0.0, camera: str = "", distortion: str = "", frame: int = 0,
                 units: str = "m", sensor: str = "") -> None:
        """unit: metres a count. camera: fx,fy,cx,cy. units of a cloud: m, cm, mm. sensor: a name of data/sensors,
        or a file."""

class DepthImage:
    """Depths along the optical axis, 0 where there is none, of a camera without distortion."""
    def __init__(self, z: NDArray[Any], fx: float, fy: float, cx: float, cy: float) -> None: ...
    @property
    def z(self) -> NDArray[np.float32]:
        """Height x width."""
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    def cloud(self) -> NDArray[np.float32]:
        """Height x width x 3 in C, NaN where there is no depth."""

def read_cloud(path: str) -> NDArray[np.float32]:
    """Points of a PLY or PCD file: N x 3, or height x width x 3."""

def read_depth(path: str, camera_pose: Optional[PoseLike] = None, world: bool = False,
               depth: DepthInput = ...) -> tuple[DepthImage, Optional[Floats]]:
    """Depth image of a scene file, PNG, recording or cloud, and T_W_C if it is known."""

class Scene:
    """A simulated view of stones on a table, with the truth about it."""
    @property
    def depth(self) -> DepthImage: ...
    @property
    def depth_unit(self) -> float: ...
    @property
    def T_W_C(self) -> Floats: ...
    @property
    def stones(self) -> list[tuple[str, Floats]]:
        """Names and true poses T_W_O."""

def render(out: str = "", *, stones: Names = None, seed: Optional[int] = None, catalogue: CatalogueLike = None,
           options: Options = ...) -> Scene:
    """Scatters stones and takes a depth image. out: folder to write it to; empty: none."""

class Detection:
    """A stone that was found."""
    @property
    def stone(self) -> str: ...
    @property
    def T_C_O(self) -> Floats: ...
    @property
    def T_W_O(self) -> Optional[Floats]: ...
    @property
    def score(self) -> float: ...
    @property
    def inlier_ratio(self) -> float: ...
    @property
    def visible(self) -> float: ...
    @property
    def certainty(self) -> float: ...
    @property
    def covariance_C(self) -> Floats:
        """6 x 6: position, then rotation vector."""

class Detections:
    """Stones that were found, best score first."""
    @property
    def detections(self) -> list[Detection]: ...
    @property
    def T_W_C(self) -> Optional[Floats]: ...
    @property
    def note(self) -> str: ...
    @property
    def depth_scale(self) -> float: ...
    @property
    def depth_scale_sigma(self) -> float: ...
    def __len__(self) -> int: ...
    def json(self) -> str:
        """What `stonestack detect --json` prints."""

SceneLike = Union[str, "PathLike[str]", DepthImage]

def detect(scene: Union[SceneLike, list[SceneLike]], *, camera_pose: Union[PoseLike, list[PoseLike], None] = None,
           world: bool = False, stones: Names = None, seed: Optional[int] = None, catalogue: CatalogueLike = None,
           options: Options = ..., depth: DepthInput = ...) -> Detections:
    """Finds stones in one depth view, or in several of one scene, of which each needs a pose."""

class Plane:
    """The points p with normal . p = offset."""
    @property
    def normal(self) -> Floats:
        """Unit vector, 3."""
    @property
    def offset(self) -> float:
        """Metres."""

class SegmentedObject:
    """An object that nobody knew, as far as it was seen."""
    @property
    def cloud_C(self) -> NDArray[np.float32]:
        """Seen surface in C, N x 3."""
    @property
    def normals_C(self) -> NDArray[np.float32]:
        """Normals of the seen surface towards the camera in C, N x 3."""
    @property
    def p_C_middle(self) -> Floats:
        """Mean of the seen surface in C, 3."""
    @property
    def p_W_middle(self) -> Optional[Floats]:
        """Mean of the seen surface in W, 3; None where the pose of the camera is not known."""
    @property
    def size(self) -> Floats:
        """Extents of the seen surface, 3: longest and shortest along the table, and from the table up."""
    @property
    def pixels(self) -> int:
        """Of all views."""
    @property
    def views(self) -> int:
        """Number of views that show it."""
    @property
    def confidence(self) -> float:
        """Estimated probability that it is one whole object as far as it is seen."""
    @property
    def cut_off(self) -> bool:
        """True if it reaches the border of an image, so that a part of it is out of view."""

class Segmentation:
    """Objects on a table, the one with most pixels first; none: `note` says why. C is the camera of the first
    view."""
    @property
    def objects(self) -> list[SegmentedObject]: ...
    @property
    def labels(self) -> list[NDArray[np.int32]]:
        """Label images, height x width, a view each: 1 + index into `objects`, 0 where there is none. Empty
        where a view shows no table or nothing on it."""
    @property
    def table_C(self) -> Optional[Plane]:
        """Plane of the table in C, its normal towards the camera; None: no table was found."""
    @property
    def T_W_C(self) -> Optional[Floats]: ...
    @property
    def note(self) -> str:
        """Reason why there is no object, or what is odd; empty otherwise."""
    @property
    def warnings(self) -> list[str]:
        """Objects that may be several, or a part of one."""
    def __len__(self) -> int: ...
    def json(self) -> str:
        """What `stonestack segment --json` prints."""
    def write(self, folder: str) -> None:
        """Writes object_1.ply and so on, and labels_1.png and so on, as `stonestack segment --out` does."""
    def draw(self, path: str) -> None:
        """Draws the views with the objects in colours and their numbers (PNG)."""

def segment(scene: Union[SceneLike, list[SceneLike]], *,
            camera_pose: Union[PoseLike, list[PoseLike], None] = None, world: bool = False,
            min_width: float = 0.02, usual_size: float = 0.4, farthest: float = 2.0,
            depth: DepthInput = ...) -> Segmentation:
    """Parts unknown objects that stand on a table, touching and stacked ones too, in one depth view or in
    several of one scene, of which each needs a pose.

    min_width: m, square root of the seen area of the smallest object, 0.002 to 1. usual_size: m, longest extent
    as expected, 0.02 to 5; larger objects get less confidence. farthest: m, depths beyond are ignored, 0.2 to
    20. A view without a table or with nothing on it gives no objects and a note.
    Raises FileError for a scene that cannot be read, InvalidArgument for a value out of its range."""

class Placement:
    """A stone and the pose where it should go."""
    @property
    def stone(self) -> str: ...
    @property
    def T_W_O(self) -> Floats: ...
    @property
    def cost(self) -> float: ...
    @property
    def terms(self) -> dict[str, float]: ...
    @property
    def predicted_success(self) -> float: ...
    @property
    def expected_height(self) -> float: ...
    @property
    def support_W(self) -> Floats:
        """Corners of the support polygon, N x 3."""
    @property
    def course(self) -> Optional[int]:
        """Course of a wall's stone, 0 on the table; None: of a tower."""
    @property
    def supports(self) -> list[int]:
        """Indices of the placements that a wall's stone rests on; empty: the table, or of a tower."""

class WallMetrics:
    """Figures of a wall, as planned or as built."""
    @property
    def placed(self) -> int:
        """Stones that stand."""
    @property
    def asked(self) -> int:
        """Stones that were asked for; 0: as many as the length takes."""
    @property
    def length(self) -> float:
        """Metres, of the lowest course."""
    @property
    def height(self) -> float:
        """Metres, mean height of the tops of the highest course."""
    @property
    def width(self) -> float:
        """Metres, mean extent of the stones across the wall."""
    @property
    def fill(self) -> float:
        """Share of the wall's volume that is stone."""
    @property
    def face(self) -> float:
        """Share of the wall's face that is stone."""
    @property
    def joints(self) -> int:
        """Joints between neighbours of a course with a course above them."""
    @property
    def open_joints(self) -> int:
        """Of these, joints that run on through the course above."""
    @property
    def flatness(self) -> float:
        """Metres, root mean square of the tops of a course about their mean."""
    @property
    def margin(self) -> float:
        """In g: horizontal acceleration that the whole bears in the weakest direction."""

class SearchResult:
    """Placements that a search proposes; none: `reason` says why."""
    @property
    def placements(self) -> list[Placement]:
        """The next one, one a level, or those of a wall in the order in which they are built."""
    @property
    def alternatives(self) -> list[Placement]: ...
    @property
    def stack(self) -> list[tuple[str, Floats]]: ...
    @property
    def wall(self) -> Optional[WallMetrics]:
        """Figures of the planned wall; None: of a tower."""
    @property
    def T_W_V(self) -> Optional[Floats]:
        """Frame of the planned wall: x along it, y across, z = 0 the table; None: of a tower."""
    @property
    def site(self) -> Floats:
        """x, y."""
    @property
    def frame(self) -> str: ...
    @property
    def T_W_C(self) -> Optional[Floats]: ...
    @property
    def reason(self) -> str: ...
    @property
    def repeatable(self) -> bool: ...
    def json(self) -> str:
        """What `stonestack search --json` prints."""
    def write_scene(self, path: str) -> None:
        """Writes the planned tower or wall as a scene file."""
    def draw(self, path: str) -> None:
        """Draws the planned tower or wall (PNG)."""

def search(scene: Union[str, "PathLike[str]", None] = None, *, stones: Names = None,
           site: Union[str, Sequence[float], None] = None, robot: str = "", levels: int = 1,
           wall: WallLike = None, camera_pose: Optional[PoseLike] = None, world: bool = False,
           seed: Optional[int] = None, catalogue: CatalogueLike = None, options: Options = ...,
           depth: DepthInput = ...) -> SearchResult:
    """Finds the next stable stacking pose, a tower of `levels`, or a wall.

    wall: stones a course ("3+2+1"), metres and courses ("0.8x3"), or a target file. stones="all": all of the
    catalogue.
    Raises InvalidArgument for a wall that cannot be, and for one with `levels` or search.method=paper; FileError
    for a target file that cannot be read; Error where nothing is detected."""

class TowerCheck:
    """Whether and how firmly a stack stands."""
    @property
    def stands(self) -> bool: ...
    @property
    def clean(self) -> bool: ...
    @property
    def standing(self) -> int: ...
    @property
    def shift(self) -> float: ...
    @property
    def turn(self) -> float: ...
    @property
    def reason(self) -> str: ...
    @property
    def T_W_O(self) -> Floats:
        """Poses at the end of the simulation, N x 4 x 4."""
    @property
    def in_equilibrium(self) -> bool: ...
    @property
    def margin(self) -> float:
        """In g."""
    @property
    def direction(self) -> Floats:
        """x, y of the weakest direction."""
    @property
    def min_friction(self) -> float: ...
    @property
    def contacts_W(self) -> Floats:
        """Points, N x 3."""
    def json(self) -> str:
        """What `stonestack check --json` prints."""

def check(tower: str, *, friction: float = 0.1, seconds: float = 10.0,
          catalogue: CatalogueLike = None) -> TowerCheck:
    """Simulates the stack or the wall of a scene file and solves its equilibrium."""

class PlanStep:
    """One thing to do; a motion has a trajectory."""
    @property
    def name(self) -> str: ...
    @property
    def opening(self) -> float: ...
    @property
    def time(self) -> Floats: ...
    @property
    def q(self) -> Floats:
        """N x 6."""
    @property
    def qd(self) -> Floats:
        """N x 6."""

class Plan:
    """Grasp and motion for one stone; where `planned` is false, `reason` says why."""
    @property
    def planned(self) -> bool: ...
    @property
    def reason(self) -> str: ...
    @property
    def stone(self) -> str: ...
    @property
    def T_W_O(self) -> Floats: ...
    @property
    def T_O_T(self) -> Floats: ...
    @property
    def seconds(self) -> float: ...
    @property
    def steps(self) -> list[PlanStep]: ...
    def json(self) -> str:
        """What `stonestack plan --json` prints."""
    def csv(self) -> str:
        """What `stonestack plan --csv` writes."""

def plan(scene: str, *, stone: Optional[str] = None, target: Optional[PoseLike] = None,
         search: Union[SearchResult, str, None] = None, robot: str = "", cell: str = "",
         start: Optional[Sequence[float]] = None, seed: Optional[int] = None, catalogue: CatalogueLike = None,
         options: Options = ...) -> Plan:
    """Plans grasp and motion for one stone; targets from `search`, or `stone` and `target`."""

class PlacementRecord:
    """A stone that was handled in a run."""
    @property
    def stone(self) -> str: ...
    @property
    def level(self) -> int: ...
    @property
    def note(self) -> str: ...
    @property
    def outcome(self) -> str: ...
    @property
    def cost(self) -> float: ...
    @property
    def predicted_success(self) -> float: ...
    @property
    def T_W_O_planned(self) -> Floats: ...
    @property
    def T_W_O_measured(self) -> Optional[Floats]: ...

class Run:
    """A run in the simulated cell and its record."""
    @property
    def folder(self) -> str: ...
    @property
    def unwritten(self) -> str: ...
    @property
    def height(self) -> int: ...
    @property
    def ended(self) -> str: ...
    @property
    def reason(self) -> str: ...
    @property
    def placements(self) -> list[PlacementRecord]: ...
    @property
    def wall(self) -> Optional[WallMetrics]:
        """Figures of the wall as last observed; None: of a tower."""
    @property
    def true_height(self) -> Optional[int]: ...
    @property
    def time(self) -> Floats:
        """Of the samples, N."""
    @property
    def q(self) -> Floats:
        """Joint angles of the samples, N x 6."""
    @property
    def opening(self) -> Floats: ...
    @property
    def force(self) -> Floats: ...
    def json(self) -> str:
        """What `stonestack run --json` prints."""

def run(robot: str = "ur10", *, seed: Optional[int] = None, per_run: int = 4, wall: WallLike = None,
        out: str = "", catalogue: CatalogueLike = None, options: Options = ...) -> Run:
    """Builds a tower in the simulated cell, or a wall; never moves a real robot.

    wall: as for `search`. out: folder of the record; empty: runs/TIME-SEED.
    Raises InvalidArgument for a wall that cannot be, and for a folder with the record of another run."""

def set_log_level(level: str) -> None:
    """debug, info, warning (the default of the module), error or off; the log goes to stderr."""
