#!/bin/sh
# run.sh GODOT LIBRARY FOLDER [RENDERER ...]: tests the extension in Godot, in a copy of the project in FOLDER. Renderers: headless
# (the editor's dock too), gl_compatibility, mobile, forward_plus; all by default. Those that draw need xvfb, xauth and drivers of
# OpenGL and Vulkan.
# CULLET_CASES names the cases to draw.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
godot=$1 library=$2 work=$3
shift 3
mkdir -p "$work"
cp -r "$here"/. "$work"
rm -rf "$work/addons"
cp -r "$here/../addons" "$work/addons"
mkdir -p "$work/addons/cullet/bin" "$work/.godot"
cp "$library" "$work/addons/cullet/bin/libcullet_godot.so"
cd "$work"
# Where Godot finds an extension for the first time, `--import` aborts at its end (Godot issues 111048 and 123511): so it is told
# of it before.
echo "res://addons/cullet/cullet.gdextension" > .godot/extension_list.cfg
timeout 240 "$godot" --headless --path . --import > import.log 2>&1 || { cat import.log; exit 1; }
cases=${CULLET_CASES:-$(cat cases.txt)}
failed=0
# The addon in a project that has no library.
bare=$PWD/outside/bare
rm -rf outside
mkdir -p "$bare/addons"
touch outside/.gdignore
cp -r addons/cullet "$bare/addons/cullet"
rm -rf "$bare/addons/cullet/bin" "$bare/addons/cullet/cullet.gdextension"
cp -r editor "$bare"
grep -v main_scene project.godot > "$bare/project.godot"
for renderer in $(echo "${*:-headless gl_compatibility mobile forward_plus}" | sed 's/headless/headless editor bare/'); do
    driver=
    case $renderer in
        headless) set -- timeout 240 "$godot" --headless --path . --script res://headless.gd ;;
        editor) set -- timeout 120 "$godot" --headless --editor --path . -- editor-test ;;
        bare) set -- timeout 120 "$godot" --headless --editor --path "$bare" -- editor-test ;;
        gl_compatibility) driver=opengl3 ;;
        *) driver=vulkan ;;
    esac
    if [ -n "$driver" ]; then
        set -- timeout 460 xvfb-run -a -s "-screen 0 800x600x24" "$godot" --path . --audio-driver Dummy --fixed-fps 60 \
            --rendering-method "$renderer" --rendering-driver "$driver"
        # Probes of the simplest renderer show nothing that the mutant takes away.
        here=$cases
        if [ "$renderer" = gl_compatibility ]; then
            here=$(echo "$cases" | sed 's/probe:probe//')
        fi
        # shellcheck disable=SC2086
        set -- "$@" -- $here
    fi
    echo "$renderer:"
    code=0
    "$@" > "$renderer.log" 2>&1 || code=$?
    grep -E "^(ok|FAILED|  )|[0-9]+ failed|SCRIPT ERROR|panicked|ERROR" "$renderer.log" || true
    # The editor goes on after an error of a script.
    if [ "$code" = 0 ] && grep -q "SCRIPT ERROR" "$renderer.log"; then
        code="an error of a script"
    fi
    if [ "$code" != 0 ]; then
        echo "$renderer ended with $code; see $PWD/$renderer.log"
        failed=1
    fi
done
exit $failed
