#!/usr/bin/env bash
# Installs a build into an empty folder and uses nothing but that folder: compiles the installed headers, builds and runs a
# project that calls find_package(lightcook) and the installed examples of the encoders alone and of the program as a build step, and runs
# `lightcook demo` from another working directory.
#   [LIGHTCOOK_SOAK=1] install_test.sh BUILD_DIR [CMAKE]
set -euo pipefail
build=$1 cmake=${2:-cmake}
consumer=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/consumer
work=$(mktemp -d "${TMPDIR:-/tmp}/lightcook_install_XXXXXX")
trap 'rm -rf "$work"' EXIT
die() { echo "install_test: $*" >&2; exit 1; }

"$cmake" --install "$build" --prefix "$work/staged" >"$work/install.log" || die "cmake --install failed"
# Moved before its first use: nothing may remember where it was installed.
mv "$work/staged" "$work/prefix"
prefix=$work/prefix

for file in bin/lightcook bin/lightcook-read lib/lightcook/lightcook_images.so share/lightcook/shaders/sh.glsl share/lightcook/examples/cornell/scene.toml \
    share/doc/lightcook/copyright share/doc/lightcook/README.md include/lightcook/compress/encode.h \
    share/man/man1/lightcook.1 share/bash-completion/completions/lightcook share/zsh/vendor-completions/_lightcook \
    share/fish/vendor_completions.d/lightcook.fish; do
    [[ -s $prefix/$file ]] || die "$file is not installed"
done
if grep -rlF "$build" "$prefix/lib" --include='*.cmake'; then die "the CMake package names the build folder"; fi

"$cmake" -S "$consumer" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_PREFIX_PATH="$prefix" >"$work/configure.log" 2>&1 ||
    { cat "$work/configure.log"; die "a project with find_package(lightcook) does not configure"; }
"$cmake" --build "$work/build" >"$work/build.log" 2>&1 || { cat "$work/build.log"; die "a project with find_package(lightcook) does not build"; }
mkdir "$work/home" "$work/elsewhere"
cd "$work/elsewhere"
"$work/build/consumer" texture.ktx2

# The encoders alone: no library of images is looked for, named to the linker, or loaded.
for package in PNG draco TBB Threads; do without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
images='OpenEXR|Imath|OpenColorIO|OpenImageIO|png|draco|tbb'
"$cmake" -S "$prefix/share/lightcook/examples/encode" -B "$work/encode" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" "${without[@]}" >"$work/encode.log" 2>&1 &&
    "$cmake" --build "$work/encode" >>"$work/encode.log" 2>&1 || { cat "$work/encode.log"; die "the installed examples/encode does not build"; }
if grep -E "LINK_LIBRARIES|INCLUDES" "$work/encode/build.ninja" | sed "s#$work##g" | grep -iE "$images"; then die "lightcook::encode links them"; fi
if ldd "$work/encode/encode_example" | grep -iE "$images"; then die "the program with lightcook::encode loads them"; fi
"$work/encode/encode_example" gradient.ktx2

# The program as a step of a build that has no language. The second build finds nothing to do.
mkdir "$work/sky"
cp "$prefix/share/lightcook/examples/cornell/clear_sky_256x1.exr" "$work/sky/"
printf 'schema = 1\nname = "sky"\n[[gradient]]\nname = "sky"\nfile = "clear_sky_256x1.exr"\n' >"$work/sky/scene.toml"
export LIGHTCOOK_CACHE=$work/cache
"$cmake" -S "$prefix/share/lightcook/examples/cook_step" -B "$work/step" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -Dscene="$work/sky/scene.toml" \
    >"$work/step.log" 2>&1 && "$cmake" --build "$work/step" >>"$work/step.log" 2>&1 || { cat "$work/step.log"; die "the installed examples/cook_step fails"; }
[[ -s $work/step/cooked/cooked.json ]] || die "the installed examples/cook_step left no manifest"
"$cmake" --build "$work/step" | grep -q 'no work to do' || die "examples/cook_step cooks again although nothing changed"
! grep -q CMAKE_CXX_COMPILER "$work/step/CMakeCache.txt" || die "examples/cook_step looks for a compiler"

# In the soak: the example in OpenGL, where its own libraries are there. The build tree has compiled it too.
if [[ -n ${LIGHTCOOK_SOAK:-} && -f /usr/include/EGL/egl.h && -f /usr/include/GL/glcorearb.h && -f /usr/include/png.h ]]; then
    "$cmake" -S "$prefix/share/lightcook/examples/opengl" -B "$work/opengl" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" >"$work/opengl.log" 2>&1 &&
        "$cmake" --build "$work/opengl" >>"$work/opengl.log" 2>&1 || { cat "$work/opengl.log"; die "the installed examples/opengl does not build"; }
fi
[[ ! -e $prefix/share/lightcook/examples/web/node_modules && -s $prefix/share/lightcook/viewer/loaders/babylon.js ]] ||
    die "the npm package is not installed as it should be"

run=(env -i HOME="$work/home" PATH=/usr/bin:/bin LANG=C.UTF-8 "$prefix/bin/lightcook")
# A named layout, since trying all of them is what package_test.sh has in the soak.
"${run[@]}" demo --layout basis-4 --effort 1 -o "$work/demo" >"$work/demo.log" 2>&1 || { cat "$work/demo.log"; die "the installed 'lightcook demo' failed"; }
[[ -s $work/demo/cooked.json && -s $work/demo/report.html ]] || die "the installed 'lightcook demo' left no manifest or report"
"${run[@]}" decode texture.ktx2 texture.exr
"${run[@]}" info gradient.ktx2 >/dev/null || die "the installed program does not read the texture of examples/encode"
"${run[@]}" info texture.exr >/dev/null || true
[[ -s texture.exr ]] || die "the installed program did not decode the consumer's texture"
echo "install_test: $(find "$prefix" -type f | wc -l) files installed, consumer and examples built, demo verified"
