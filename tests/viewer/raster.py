"""Rasterizes triangles in numpy, one at a time: which place of which surface each pixel's centre shows."""
import dataclasses

import numpy as np


@dataclasses.dataclass
class Camera:
    eye: tuple
    target: tuple
    fov: float  # from the lower to the upper edge [degrees]
    size: tuple  # width and height [pixels]

    def clip_from_world(self):
        """OpenGL's perspective after OpenGL's look-at, up along Y."""
        eye, target = np.array(self.eye, float), np.array(self.target, float)
        back = (eye - target) / np.linalg.norm(eye - target)
        right = np.cross([0, 1, 0], back)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(back, right), back])
        view = np.vstack([np.column_stack([rotation, -rotation @ eye]), [0, 0, 0, 1]])
        near, far, f = 0.05, 1000.0, 1 / np.tan(np.radians(self.fov) / 2)
        projection = np.array([[f * self.size[1] / self.size[0], 0, 0, 0], [0, f, 0, 0],
                               [0, 0, (far + near) / (near - far), 2 * far * near / (near - far)], [0, 0, -1, 0]])
        return projection @ view


@dataclasses.dataclass
class Surfaces:
    """What pixels show: rows and columns of those inside a surface, and their light-map UVs, unit normals and clusters."""
    at: tuple
    uv: np.ndarray
    normal: np.ndarray
    cluster: np.ndarray


def rasterize(parts, camera):
    """parts: meshes as mesh.mjs writes them. Triangles are front faces if counterclockwise, below a matrix that mirrors if clockwise; others
    are not drawn."""
    width, height = camera.size
    depth = np.full((height, width), np.inf)
    shown = np.zeros((height, width, 6))  # uv, normal, cluster
    for part in parts:
        positions, indices = np.array(part['positions']).reshape(-1, 3), np.array(part['indices']).reshape(-1, 3)
        matrix = np.array(part['matrix']).reshape(4, 4).T
        turn = matrix[:3, :3]
        positions = positions @ turn.T + matrix[:3, 3]
        normals = np.array(part['normals']).reshape(-1, 3) @ np.linalg.inv(turn)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        if np.linalg.det(turn) < 0:
            indices = indices[:, ::-1]
        clusters = np.array(part['clusters']) if part['clusters'] else np.zeros(len(positions))
        values = np.column_stack([np.array(part['uvs']).reshape(-1, 2), normals, clusters])
        clip = np.column_stack([positions, np.ones(len(positions))]) @ camera.clip_from_world().T
        assert (clip[indices.ravel(), 3] > 0.05).all(), 'a triangle reaches behind the camera'
        x, y = (clip[:, 0] / clip[:, 3] * 0.5 + 0.5) * width, (0.5 - clip[:, 1] / clip[:, 3] * 0.5) * height
        for corners in indices:
            fill(depth, shown, x[corners], y[corners], clip[corners, 2] / clip[corners, 3], clip[corners, 3], values[corners])
    inside = inside_surfaces(np.isfinite(depth), shown)
    normal = shown[inside][:, 2:5]
    return Surfaces(np.nonzero(inside), shown[inside][:, :2].T, normal / np.linalg.norm(normal, axis=1, keepdims=True), np.rint(shown[inside][:, 5]))


def inside_surfaces(covered, shown):
    """True for pixels whose neighbours show the same surface. At its edge, a rasterizer that rounds corners to sixteenths of a pixel, as
    SwiftShader does, may draw another one."""
    inside = covered.copy()
    inside[[0, -1]] = inside[:, [0, -1]] = False
    for axis in (0, 1):
        for step in (1, -1):
            beside = np.roll(shown, step, axis)
            same = np.abs(beside[..., :2] - shown[..., :2]).max(-1) < 0.02
            same &= (beside[..., 2:5] * shown[..., 2:5]).sum(-1) > 0.9
            inside &= np.roll(covered, step, axis) & same
    return inside


def fill(depth, shown, x, y, z, w, values):
    """Draws a triangle with corners x, y [pixels], depth z, and what is interpolated with perspective: w and values of the corners."""
    area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    left, right = max(int(np.floor(x.min())), 0), min(int(np.ceil(x.max())), depth.shape[1])
    top, bottom = max(int(np.floor(y.min())), 0), min(int(np.ceil(y.max())), depth.shape[0])
    if area >= 0 or left >= right or top >= bottom:  # rows go down, so that a front face has a negative area
        return
    px, py = np.meshgrid(np.arange(left, right) + 0.5, np.arange(top, bottom) + 0.5)
    weights = np.stack([((x[j] - px) * (y[k] - py) - (x[k] - px) * (y[j] - py)) / area for j, k in ((1, 2), (2, 0), (0, 1))], -1)
    here = (weights >= 0).all(-1)
    depths = weights @ z
    here &= depths < depth[top:bottom, left:right]
    depth[top:bottom, left:right][here] = depths[here]
    perspective = weights[here] / w
    perspective /= perspective.sum(1, keepdims=True)
    shown[top:bottom, left:right][here] = perspective @ values
