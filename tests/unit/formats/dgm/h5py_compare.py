#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares every layer of sample .dgm files three ways: as meant, as h5py reads it, and as the index points to it."""
import glob
import os
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy as np

TYPES = {1: "<u1", 2: "<u2", 3: "<u4", 4: "<i2", 5: "<f2", 6: "<f4"}


def read_index(raw):
    """Records by (chart, layer), read by the words of formats/SPEC.md alone."""
    assert raw[:8] == b"DGMv\r\n\x1a\n"
    version, header_bytes, file_bytes, offset, size, charts, layers = struct.unpack_from("<IIQQQII", raw, 8)
    assert (version, header_bytes, file_bytes) == (1, 128, len(raw))
    assert size == 192 * charts + 104 * layers
    out = {}
    for k in range(layers):
        name, chart, kind, rank, _ = struct.unpack_from("<24sIIII", raw, offset + 192 * charts + 104 * k)
        numbers = struct.unpack_from("<4QQQ", raw, offset + 192 * charts + 104 * k + 40)
        out[chart, name.rstrip(b"\0").decode()] = (TYPES[kind], numbers[:rank], numbers[4], numbers[5])
    grids = [struct.unpack_from("<IIIIII12d16s", raw, offset + 192 * k) for k in range(charts)]
    return out, grids


def compare(stem):
    with open(stem + ".dgm", "rb") as file:
        raw = file.read()
    index, grids = read_index(raw)
    layers = 0
    with h5py.File(stem + ".dgm", "r") as h5, open(stem + ".txt", encoding="utf-8") as expected:
        assert h5.userblock_size == 4096
        assert list(h5.attrs["format_version"]) == [1]
        assert h5.attrs["generator"] == b"test 1.0" or h5.attrs["generator"] == "test 1.0"
        report = h5["report"][()]
        assert report == b'{"rms":1.25e-05,"text":"caf\\u00e9"}', report
        for line in expected:
            words = line.split()
            if words[0] == "set":
                assert [np.bytes_(h5.attrs[a]).decode() for a in ("source_hash", "settings_hash")] == words[1:]
                assert raw[64:80].hex() == words[1] and raw[80:96].hex() == words[2]
            elif words[0] == "chart":
                group, grid = h5["charts"][words[1]], grids[int(words[1])]
                assert [int(group.attrs[a][0]) for a in ("rows", "cols")] == [int(w) for w in words[2:4]] == list(grid[:2])
                assert np.bytes_(group.attrs["domain"]).decode() == words[4] == ("square", "free")[grid[2]]
                assert np.bytes_(group.attrs["method"]).decode() == words[5] == grid[18].rstrip(b"\0").decode()
                numbers = [float(w) for w in words[6:]]
                assert list(group.attrs["bbox"]) == numbers[:6] and list(grid[6:18]) == numbers
                assert list(group["geometry"].attrs["offset"]) == numbers[6:9]
                assert list(group["geometry"].attrs["scale"]) == numbers[9:]
                assert group["collision"].attrs["levels"].tolist() == [[8, 8], [4, 4], [2, 2], [1, 1]]
            else:
                chart, name, kind, path, shape = int(words[1]), words[2], words[3], words[4], tuple(map(int, words[5:]))
                meant = np.fromfile(path, dtype="<" + kind).reshape(shape)
                dataset = h5["charts"][words[1]][name]
                assert dataset.dtype == meant.dtype and dataset.shape == shape, (name, dataset.dtype, dataset.shape)
                assert dataset.chunks is None and dataset.compression is None
                assert dataset[()].tobytes() == meant.tobytes(), name
                kind_in_index, shape_in_index, offset, size = index.pop((chart, name))
                assert np.dtype(kind_in_index) == meant.dtype and shape_in_index == shape and size == meant.nbytes
                if size:
                    assert dataset.id.get_offset() == offset
                assert raw[offset:offset + size] == meant.tobytes(), name
                layers += 1
    assert not index, index
    return layers


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], folder], check=True)
        stems = sorted(path[:-4] for path in glob.glob(os.path.join(folder, "*.dgm")))
        assert len(stems) == 3
        counts = [compare(stem) for stem in stems]
    assert max(counts) > 64, counts
    print("layers compared:", counts)


if __name__ == "__main__":
    main()
