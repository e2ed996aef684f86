#!/bin/sh
# get-godot.sh FOLDER [SUITE]: unpacks Debian's Godot 4, with all its libraries and Mesa's software drivers, beside the system;
# nothing is installed. FOLDER/godot then runs it. Fetches 180 MB, and takes 660 MB. For Debian on x86-64, as any user.
set -eu
mkdir -p "$1"
folder=$(cd "$1" && pwd)
suite=${2:-testing}
mkdir -p "$folder/apt/lists/partial" "$folder/apt/archives/partial" "$folder/root"
mirror=$(sed -n 's/^URIs: *//p' /etc/apt/sources.list.d/debian.sources | head -n 1)
keys=/usr/share/keyrings/debian-archive-keyring.gpg
echo "deb [signed-by=$keys] ${mirror%% *} $suite main" > "$folder/apt/sources.list"
# Its own lists and an empty status, from which apt resolves everything down to libc.
get() {
    apt-get -q -o Dir::Etc::sourcelist="$folder/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o Dir::State::Lists="$folder/apt/lists" -o Dir::Cache="$folder/apt" -o Dir::State::status=/dev/null \
        -o Debug::NoLocking=1 -o APT::Sandbox::User= "$@"
}
get update
get install -y --no-install-recommends --download-only godot libvulkan1 mesa-vulkan-drivers libgl1 libglx-mesa0 \
    libgl1-mesa-dri libegl1 libxkbcommon-x11-0
for package in "$folder"/apt/archives/*.deb; do
    dpkg-deb -x "$package" "$folder/root"
done
libraries=$folder/root/usr/lib/x86_64-linux-gnu
# The driver's file names its library without a folder, for which the system's linker would be asked.
sed "s|\"libvulkan_lvp.so\"|\"$libraries/libvulkan_lvp.so\"|" "$folder/root/usr/share/vulkan/icd.d/lvp_icd.json" > "$folder/lvp.json"
cat > "$folder/godot" <<END
#!/bin/sh
export VK_DRIVER_FILES=$folder/lvp.json LIBGL_DRIVERS_PATH=$libraries/dri
export __EGL_VENDOR_LIBRARY_DIRS=$folder/root/usr/share/glvnd/egl_vendor.d XKB_CONFIG_ROOT=$folder/root/usr/share/X11/xkb
exec $libraries/ld-linux-x86-64.so.2 --library-path $libraries:$libraries/pulseaudio $folder/root/usr/bin/godot "\$@"
END
chmod +x "$folder/godot"
rm -rf "$folder/apt/archives"
"$folder/godot" --headless --version
