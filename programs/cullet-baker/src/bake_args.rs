//! The command line of `cullet bake`.

use std::path::PathBuf;

use clap::Args;

use cullet_command::args::{SceneArgs, UnitArgs};

/// End of `cullet bake --help`.
pub(crate) const BAKE_HELP: &str = "\
The file is a GLB that any viewer opens. Of a .glb or .gltf it is that file as it was, with its textures,
animations, skins and extras, and with what lay in other files taken in; any other scene is written as GLB. In
the extension CULLET_baked beside each mesh are its levels of detail, with how far each of them is off, as
measured. Every mesh gets a chain of whole meshes, each of fewer triangles; above 5,000 triangles also a
hierarchy of clusters, of which what is near is drawn fine and what is far is drawn coarse. Meshes that deform
have none. Loading the file gives the scene these levels: cullet info lists them, cullet info --baked at once.

With --merge neighbouring instances are merged in groups, and groups in larger ones; a group is drawn in the
place of all of its instances where it is near enough to them and has fewer triangles.

The same scene and options make the same bytes, with any number of threads. --resume keeps what is finished of
each mesh and merged group in a folder, and takes from there what was finished before: after Ctrl-C, or where
a few meshes of many have changed. OUT is replaced when all of it has been written, never by half of it.

--unit I/N makes one of N shares of the levels, occluders, impostors and merged groups and writes no OUT; any number
of processes may share a folder, on one machine or many. Once all have ended, --resume joins them, and makes what
is missing. Impostors and groups are made of levels, and large groups of small ones: of these a share makes those
of others too that it needs and that are not there by then.

With --up, --one-sided, --two-sided or --cells the scene is another than the one in the file, and is written
anew: without textures and animations, and what moves stands as it is stored.

--impostors adds pictures of a mesh from 144 directions, with coverage, depth, normals and materials, and how
far what is drawn of them is off, as measured. They are drawn by verify, report and picture; other programs
that load the file leave them out unless they ask for them.

The work is done by a program of its own, cullet-baker. It is looked for beside this program, then in PATH; a
'cullet' that cargo built in the folder of its source builds it at the first call.

Examples
  cullet bake model.glb -o baked.glb
  cullet bake city -o city.glb                       a built-in scene
  cullet bake castle.glb -o baked.glb --merge        levels of groups of instances too
  cullet bake castle.glb -o baked.glb --resume       goes on where Ctrl-C stopped it
  cullet bake castle.glb -o baked.glb --unit 3/8 --units /shared/castle
                                                     the third of eight machines
  cullet bake forest.glb -o baked.glb --impostors    and pictures of what is far away
  cullet bake scan.ply -o baked.glb --no-hierarchy   whole levels only
  cullet bake castle.glb -o baked.glb --occluders    what hides what is behind it too
  cullet bake model.glb -o baked.glb --json -        the figures as JSON
  cullet info baked.glb                              what is baked of each mesh";

/// Arguments of `cullet bake`.
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The file to write: a .glb
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub out: PathBuf,
    /// No hierarchies of clusters
    #[arg(long)]
    pub no_hierarchy: bool,
    /// No chains of whole meshes
    #[arg(long, conflicts_with = "no_hierarchy")]
    pub no_chain: bool,
    /// Occluders of every mesh too, so that --occluders auto and baked need not make them
    #[arg(long)]
    pub occluders: bool,
    /// Chains as nodes too, by `MSFT_lod`, for programs that draw those; of a glTF alone
    #[arg(long, conflicts_with = "no_chain")]
    pub msft_lod: bool,
    /// Groups of instances too, merged and simplified as one, each of which stands for all of them
    /// from afar
    #[arg(long)]
    pub merge: bool,
    /// Impostors too, of meshes of which many triangles would be drawn far away: pictures from all
    /// around
    #[arg(long)]
    pub impostors: bool,
    /// Write each impostor as PNGs and as a glTF of cards too, into this folder
    #[arg(long, value_name = "PATH", requires = "impostors")]
    pub impostor_sheets: Option<PathBuf>,
    /// Share of the work to do, and where finished work is kept: a file for each mesh and kind, and
    /// each merged group.
    #[command(flatten)]
    pub units: UnitArgs,
    /// How many threads [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub json: Option<PathBuf>,
}
