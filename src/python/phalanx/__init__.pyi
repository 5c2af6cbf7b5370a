from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__ = ["AllHits", "Hits", "Scene", "isa"]

# Two points, a vector, and the vertical field of view in degrees.
_Vector = Sequence[float] | NDArray[np.float32] | NDArray[np.float64]
_Camera = tuple[_Vector, _Vector, _Vector, float]
_Quality = Literal["fastest", "fast", "medium", "best"]

def isa() -> str: ...
@final
class Scene:
    def __new__(cls, origin: _Vector = (0.0, 0.0, 0.0)) -> Scene: ...
    @staticmethod
    def load(path: str | PathLike[str], threads: int | None = None) -> Scene: ...
    @staticmethod
    def open(path: str | PathLike[str]) -> Scene: ...
    def save(self, path: str | PathLike[str]) -> None: ...
    def add_mesh(self, vertices: ArrayLike, faces: ArrayLike) -> int: ...
    def add_spheres(self, centers: ArrayLike, radii: ArrayLike) -> int: ...
    def add_prototype(self, vertices: ArrayLike, faces: ArrayLike) -> int: ...
    def add_instance(self, prototype: int, transform: ArrayLike) -> int: ...
    def build(self, quality: _Quality = "medium", threads: int | None = None) -> None: ...
    def first_prim(self, geom_id: int) -> int | None: ...
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
    ) -> Hits: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
    ) -> NDArray[np.bool_]: ...
    def count(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
    ) -> NDArray[np.uint32]: ...
    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
    ) -> AllHits: ...
    @overload
    def render(
        self,
        camera: _Camera | None = None,
        size: tuple[int, int] | None = None,
        spp: int = 1,
        max_depth: int | None = None,
        aovs: None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]: ...
    @overload
    def render(
        self,
        camera: _Camera | None = None,
        size: tuple[int, int] | None = None,
        spp: int = 1,
        max_depth: int | None = None,
        *,
        aovs: list[str],
        threads: int | None = None,
    ) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]: ...
    @overload
    def render(
        self,
        camera: _Camera | None,
        size: tuple[int, int] | None,
        spp: int,
        max_depth: int | None,
        aovs: list[str],
        threads: int | None = None,
    ) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]: ...
    def depth(
        self,
        camera: _Camera | None = None,
        size: tuple[int, int] | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]: ...
    def bench(
        self,
        rays: list[str] | None = None,
        camera: _Camera | None = None,
        size: tuple[int, int] = (512, 512),
        threads: int | None = None,
        repeat: int = 5,
        name: str = "scene",
    ) -> dict[str, Any]: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...
    def __len__(self) -> int: ...

@final
class Hits:
    @property
    def t(self) -> NDArray[np.float32]: ...
    @property
    def u(self) -> NDArray[np.float32]: ...
    @property
    def v(self) -> NDArray[np.float32]: ...
    @property
    def prim_id(self) -> NDArray[np.int32]: ...
    @property
    def geom_id(self) -> NDArray[np.int32]: ...
    @property
    def hit(self) -> NDArray[np.bool_]: ...
    @property
    def normal(self) -> NDArray[np.float32]: ...
    def refine(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def __len__(self) -> int: ...

@final
class AllHits:
    @property
    def starts(self) -> NDArray[np.int64]: ...
    @property
    def ray_id(self) -> NDArray[np.int64]: ...
    @property
    def t(self) -> NDArray[np.float32]: ...
    @property
    def u(self) -> NDArray[np.float32]: ...
    @property
    def v(self) -> NDArray[np.float32]: ...
    @property
    def prim_id(self) -> NDArray[np.int32]: ...
    @property
    def geom_id(self) -> NDArray[np.int32]: ...
    def refine(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def __len__(self) -> int: ...
