//! Bytes to meshes, scene files, pictures, rays and checkpoints, and back. Parsers take bytes or text; paths appear at the edge only.

mod atomic;
mod block_log;
mod builtin;
mod checkpoint_file;
pub mod gltf;
pub mod gmsh;
mod image_file;
mod load;
mod material_library;
pub mod medit;
mod merging;
mod mesh_file;
mod mesh_format;
mod mesh_parts;
mod mesh_reading;
mod mesh_source;
mod mesh_writing;
mod model;
mod model_loading;
mod model_writing;
pub mod mtl;
pub mod npy;
pub mod obj;
pub mod off;
mod origin;
mod part_name;
mod picture_file;
pub mod ply;
mod radiance_file;
#[cfg(test)]
mod random_edits;
mod ray_file;
mod remarks;
mod render_description;
mod save;
pub mod scene_file;
mod scene_paths;
mod shorten;
pub mod stl;
mod texture_file;
mod texture_loader;
mod unless;
mod whole_file;

pub use atomic::{check_writable, exit_process, remove_unfinished, write_atomically};
pub use block_log::{BlockLog, LoggedBlocks, block_record};
pub use checkpoint_file::{CheckpointError, load_checkpoint, save_checkpoint};
pub use image_file::{
    ImageFileError, check_image_path, holds_layers, rescue_prefix, rescue_render, write_image,
    write_render, write_render_unless,
};
pub use load::{
    Found, LoadError, LoadedScene, LoadedWithout, MissingFile, MissingKind, Moves,
    READ_FROM_OUTSIDE, STRETCHED, demo_scene, holds_other_scene, image_warnings, load_image,
    load_mesh, load_scene, load_scene_without_missing, load_scenes, lost_digits_warning,
    mesh_warnings, missing_files, missing_in, moved_along, override_scene, reload_scene,
    texture_warnings,
};
pub use mesh_file::{Dropped, MaterialLibrary, MeshError, MeshFile};
pub use mesh_format::{MeshFormat, READABLE_EXTENSIONS, READABLE_FORMATS};
pub use mesh_parts::MeshParts;
pub use mesh_reading::{List, Malformed, Place};
pub use model::{Model, ModelFacts};
pub use model_loading::{ReadAgain, load_again, load_model, load_models, scene_of_models};
pub use model_writing::{ModelFormat, WriteError, write_model};
pub use origin::{Origin, Values, WrittenError, WrittenOrigin};
pub use part_name::file_and_part;
pub use picture_file::{
    PICTURE_FORMATS, PictureError, PictureFile, RenderFile, parse_image, parse_render, read_image,
    read_image_unless, read_render,
};
pub use radiance_file::{
    RADIANCE_EXTENSIONS, RADIANCE_FORMATS, RadianceError, RadianceFile, parse_radiance,
};
pub use ray_file::{RayFileError, load_rays, save_rays};
pub use remarks::Remarks;
pub use render_description::{describe_render, difference};
pub use save::{SaveError, save_scene};
pub use scene_paths::{
    RENDER_EXTENSIONS, absolute_image, absolute_mesh, is_image_file, is_render_file, is_scene_file,
};
pub use texture_file::{
    TEXTURE_EXTENSIONS, TEXTURE_FORMATS, TextureFile, load_texture, parse_texture,
};
pub use texture_loader::load_textures_again;
pub use whole_file::open_file;
