from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__ = ["AllHits", "Hits", "Scene", "isa"]

# Two points, a vector, and the vertical field of view in degrees; for parallel rays also a height. Or a matrix, and that angle.
_Vector = Sequence[float] | NDArray[np.float32] | NDArray[np.float64]
_LookAt = tuple[_Vector, _Vector, _Vector, float]
_Parallel = tuple[_Vector, _Vector, _Vector, float, float]
_Camera = _LookAt | _Parallel | tuple[ArrayLike, float]
_Quality = Literal["fastest", "fast", "medium", "best"]
_UpdateMode = Literal["auto", "refit", "rebuild"]

def isa() -> str: ...
@final
class Scene:
    def __new__(cls, origin: _Vector = (0.0, 0.0, 0.0)) -> Scene: ...
    @staticmethod
    def load(
        path: str | PathLike[str],
        threads: int | None = None,
        camera: str | int | None = None,
        headlight: bool = False,
    ) -> Scene: ...
    @staticmethod
    def open(path: str | PathLike[str]) -> Scene: ...
    def save(self, path: str | PathLike[str]) -> None: ...
    def add_mesh(self, vertices: ArrayLike, faces: ArrayLike) -> int: ...
    def add_spheres(self, centers: ArrayLike, radii: ArrayLike) -> int: ...
    def add_prototype(self, vertices: ArrayLike, faces: ArrayLike) -> int: ...
    def add_instance(self, prototype: int, transform: ArrayLike) -> int: ...
    def set_vertices(self, geom_id: int, vertices: ArrayLike) -> None: ...
    def set_prototype_vertices(self, prototype: int, vertices: ArrayLike) -> None: ...
    def set_transform(self, geom_id: int, transform: ArrayLike) -> None: ...
    def set_mask(self, geom_id: int, mask: int) -> None: ...
    def set_name(self, geom_id: int, name: str) -> None: ...
    def prim_names(self, prim_id: ArrayLike) -> list[tuple[str | None, str | None]]: ...
    def remove(self, geom_id: int) -> None: ...
    def remove_prototype(self, prototype: int) -> None: ...
    def update(self, mode: _UpdateMode = "auto") -> dict[str, Any]: ...
    def build(self, quality: _Quality = "medium", threads: int | None = None) -> None: ...
    def first_prim(self, geom_id: int) -> int | None: ...
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
        *,
        tnear: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        ignore: ArrayLike | None = None,
    ) -> Hits: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
        *,
        tnear: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        ignore: ArrayLike | None = None,
    ) -> NDArray[np.bool_]: ...
    def count(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
        *,
        tnear: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        ignore: ArrayLike | None = None,
    ) -> NDArray[np.uint32]: ...
    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        threads: int | None = None,
        *,
        tnear: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        ignore: ArrayLike | None = None,
    ) -> AllHits: ...
    @overload
    def render(
        self,
        camera: _Camera | None = None,
        size: tuple[int, int] | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        aovs: None = None,
        threads: int | None = None,
        exposure: float | Literal["auto"] | None = None,
        tone: Literal["linear", "neutral"] = "linear",
    ) -> NDArray[np.float32]: ...
    @overload
    def render(
        self,
        camera: _Camera | None = None,
        size: tuple[int, int] | None = None,
        spp: int | None = None,
        max_depth: int | None = None,
        *,
        aovs: list[str],
        threads: int | None = None,
        exposure: float | Literal["auto"] | None = None,
        tone: Literal["linear", "neutral"] = "linear",
    ) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]: ...
    @overload
    def render(
        self,
        camera: _Camera | None,
        size: tuple[int, int] | None,
        spp: int | None,
        max_depth: int | None,
        aovs: list[str],
        threads: int | None = None,
        exposure: float | Literal["auto"] | None = None,
        tone: Literal["linear", "neutral"] = "linear",
    ) -> dict[str, NDArray[np.float32] | NDArray[np.int32]]: ...
    def camera(self, size: tuple[int, int] | None = None) -> _LookAt | _Parallel: ...
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
    def environment(self) -> NDArray[np.float32] | None: ...
    @environment.setter
    def environment(self, value: str | PathLike[str] | ArrayLike | None) -> None: ...
    @property
    def environment_turn(self) -> float: ...
    @environment_turn.setter
    def environment_turn(self, degrees: float) -> None: ...
    @property
    def bounds(self) -> NDArray[np.float64]: ...
    @property
    def names(self) -> list[dict[str, int]]: ...
    @property
    def cameras(self) -> list[str | None]: ...
    def __len__(self) -> int: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, _memo: dict[int, Any], /) -> Scene: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, bytes: bytes, /) -> None: ...

@final
class Hits:
    def __new__(
        cls,
        t: NDArray[np.float32],
        u: NDArray[np.float32],
        v: NDArray[np.float32],
        prim_id: NDArray[np.int32],
        geom_id: NDArray[np.int32],
        normal: NDArray[np.float32],
        refined: tuple[NDArray[np.float64], NDArray[np.float64]],
    ) -> Hits: ...
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
    def __copy__(self) -> Hits: ...
    def __getitem__(self, index: Any, /) -> Hits: ...
    def _repr_html_(self) -> str: ...
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
