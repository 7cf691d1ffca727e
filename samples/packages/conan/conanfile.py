# SPDX-License-Identifier: GPL-3.0-or-later
"""Conan 2 recipe of the runtime: `conan create samples/packages/conan` from the root of the repository."""
from pathlib import Path

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Dgm(ConanFile):
    name = "dgm"
    version = "0.1.0"
    description = "Runtime of deformable geometry maps"
    license = "MIT"
    package_type = "library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False]}
    default_options = {"shared": False}

    def export_sources(self):
        root = Path(self.recipe_folder).parents[2]
        for pattern in ("CMakeLists.txt", "LICENSES/*", "libdgm/*", "scripts/cmake/*"):
            copy(self, pattern, root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def validate(self):
        check_min_cppstd(self, 20)

    def requirements(self):
        self.requires("xxhash/0.8.2", visible=False)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update(DGM_BUILD_TOOLS=False, DGM_BUILD_TESTS=False)
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "MIT.txt", Path(self.source_folder) / "LICENSES", Path(self.package_folder) / "licenses")

    def package_info(self):
        kind = "dgm" if self.options.shared else "dgm_static"
        self.cpp_info.libs = [kind]
        self.cpp_info.set_property("cmake_target_name", f"dgm::{kind}")
        self.cpp_info.set_property("pkg_config_name", "dgm")
        if self.settings.os == "Linux":
            self.cpp_info.system_libs = ["m"]
