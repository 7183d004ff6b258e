"""Shading on the CPU in numpy, written from docs/theory: what the page's pixels are compared with."""
import numpy as np
import OpenImageIO as oiio


def read_exr(path):
    """Channels of an EXR by name, float32."""
    file = oiio.ImageInput.open(str(path))
    spec = file.spec()
    pixels = np.asarray(file.read_image(0, 0, 0, spec.nchannels, 'float')).reshape(spec.height, spec.width, spec.nchannels)
    file.close()
    return {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)}


def read_picture(path):
    """[height, width, 3] of an 8-bit picture, in [0, 255]."""
    file = oiio.ImageInput.open(str(path))
    spec = file.spec()
    pixels = np.asarray(file.read_image(0, 0, 0, 3, 'uint8')).reshape(spec.height, spec.width, 3)
    file.close()
    return pixels.astype(float)


def write_exr(path, channels, kind='float'):
    names = list(channels)
    height, width = channels[names[0]].shape
    spec = oiio.ImageSpec(width, height, len(names), kind)
    spec.channelnames = names
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec), file.geterror()
    assert file.write_image(np.ascontiguousarray(np.stack([channels[name] for name in names], -1), np.float32)), file.geterror()
    file.close()


def sh_of(channels):
    """[height, width, 9, 3] of channels sh00.R .. sh08.B."""
    return np.stack([np.stack([channels[f'sh{k:02d}.{c}'] for c in 'RGB'], -1) for k in range(9)], -2).astype(np.float64)


def basis(n):
    """The nine basis functions at unit directions [..., 3]."""
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    one = np.ones_like(x)
    a, b = np.sqrt(15 / np.pi) / 2, np.sqrt(3 / (4 * np.pi))
    return np.stack([one * np.sqrt(1 / np.pi) / 2, b * y, b * z, b * x, a * x * y, a * y * z, np.sqrt(5 / np.pi) / 4 * (3 * z * z - 1), a * x * z,
                     a / 2 * (x * x - y * y)], -1)


BANDS = np.array([1] + 3 * [2 / 3] + 5 * [1 / 4])


def exit_radiance(sh, n):
    """Of a white Lambert surface. sh [..., 9, 3], n [..., 3]."""
    return np.einsum('...k,...kc->...c', BANDS * basis(n), sh)


def local_sh(sh, x, y, z):
    """Coefficients in a local frame, by projecting onto directions: band 2 is exact for any set of directions that spans it."""
    i = np.arange(200) + 0.5
    polar, azimuth = np.arccos(1 - 2 * i / 200), np.pi * (1 + 5 ** 0.5) * i
    local = np.stack([np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)], -1)
    inverse = np.linalg.pinv(basis(local))
    world = local[:, None, 0, None] * x + local[:, None, 1, None] * y + local[:, None, 2, None] * z
    values = np.einsum('dnk,nkc->dnc', basis(world), sh)
    return np.einsum('kd,dnc->nkc', inverse, values)


def bilinear(image, u, v):
    """Filters an image [height, width, ...] at texture coordinates, clamped."""
    height, width = image.shape[:2]
    x, y = np.clip(u * width - 0.5, 0, width - 1), np.clip(v * height - 0.5, 0, height - 1)
    x0, y0 = np.minimum(x.astype(int), max(width - 2, 0)), np.minimum(y.astype(int), max(height - 2, 0))
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    shape = (-1,) + (1,) * (image.ndim - 2)
    fx, fy = (x - x0).reshape(shape), (y - y0).reshape(shape)
    return (1 - fy) * ((1 - fx) * image[y0, x0] + fx * image[y0, x1]) + fy * ((1 - fx) * image[y1, x0] + fx * image[y1, x1])


def bilinear_of_covered(image, covered, u, v):
    """The same of the covered texels alone, as filter "decoded" has it; of all where none is covered. covered [height, width]."""
    mask = covered.astype(float)
    weight = bilinear(mask, u, v).reshape((-1,) + (1,) * (image.ndim - 2))
    inside = bilinear(image * mask.reshape(mask.shape + (1,) * (image.ndim - 2)), u, v) / np.maximum(weight, 1e-9)
    return np.where(weight > 0, inside, bilinear(image, u, v))


def learned_sh(constants, images, uv, clusters):
    """Coefficients of a learned layout with a code of four numbers and one residual layer or none (docs/theory/layouts.md).
    images: decoded textures by role; uv [2, n]; clusters [n]."""
    table, clusters = images['tables'][:, :, :3], clusters.astype(int)
    code = table[:, :120].reshape(len(table), 15, 8, 3)
    c = bilinear(images['code'], *uv)
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    monomials = np.stack([np.ones(len(c)), *c.T[:3], *(c[:, i] * c[:, j] for i, j in pairs), c[:, 3], *(c[:, i] * c[:, 3] for i in range(4))], 1)
    sh = np.concatenate([np.ones((len(c), 1, 3)), np.einsum('nj,njic->nic', monomials, code[clusters])], 1)
    if 'residual' in images:
        residual = table[:, 120:].reshape(len(table), 4, 9, 3)
        sh += np.einsum('nk,nkic->nic', bilinear(images['residual'], *uv) - constants['neutral'][0], residual[clusters])
    return constants['range'][0] * bilinear(images['l0'], *uv)[:, None, :3] * sh


def shown(light, nits, stops=0.0):
    """What the screen shows [0, 255], of Rec.709 light."""
    linear = np.clip(light * nits / 203 * 2.0 ** stops, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-12) ** (1 / 2.4) - 0.055)


def visible_error(a, b, nits, black):
    """Delta E ITP of two exit radiances in Rec.709 (docs/theory/visible.md)."""
    to2020 = np.array([[0.627404, 0.329283, 0.043313], [0.069097, 0.919540, 0.011362], [0.016391, 0.088013, 0.895595]])
    to_lms = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096

    def itp(light):
        lms = (np.maximum(light, 0) * nits + black) @ (to_lms @ to2020).T
        y = (np.clip(lms, 0, 10000) / 10000) ** (2610 / 16384)
        l, m, s = np.moveaxis(((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32), -1, 0)
        return np.stack([(l + m) / 2, (6610 * l - 13613 * m + 7003 * s) / 8192, (17933 * l - 17390 * m - 543 * s) / 4096], -1)

    return 720 * np.linalg.norm(itp(a) - itp(b), axis=-1)


class SpecularTables:
    """The cooked tables of the area-specular kernel, filtered as a GPU does."""

    def __init__(self, constants, textures):
        self.constants, self.textures = constants, textures

    def axis(self, name, t):
        k = self.constants[name]
        p0, p1, q0, q1 = k['factors']
        return np.clip(np.sqrt(np.maximum((p0 + p1 * t) * (q0 + q1 * t), 0)) * k['scale'] + k['offset'], 0, 1)

    def reflected(self, sh, n, view, m, f0):
        """Reflected radiance of SH light [n, 9, 3]."""
        cosine = np.maximum(np.sum(n * view, -1), 0)
        u, v = self.axis('view', cosine), self.axis('roughness', np.full_like(cosine, m))
        table = {role: bilinear(image, u, v) * self.constants[role + '_scale'] + self.constants[role + '_bias'] for role, image in self.textures.items()}
        x = view - np.sum(n * view, -1, keepdims=True) * n
        x /= np.linalg.norm(x, axis=-1, keepdims=True)
        local = local_sh(sh, x, np.cross(n, x), n)
        c = np.concatenate([table['c0236'], table['cd78'][:, :2]], -1)
        d = np.concatenate([table['d0236'], table['cd78'][:, 2:]], -1)
        return np.einsum('nk,nkc->nc', f0 * c + (1 - f0) * d, local[:, [0, 2, 3, 6, 7, 8]])
