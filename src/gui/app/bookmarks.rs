//! Cameras to come back to.

use super::App;
use crate::scene::Bookmark;
use crate::scene::free_name;

impl App {
    /// Remembers the camera as it is.
    pub(super) fn add_bookmark(&mut self) {
        let scene = &mut self.document.scene;
        let is_taken = |name: &str| scene.bookmarks.iter().any(|other| other.name == name);
        let name = free_name(&format!("view {}", scene.bookmarks.len() + 1), is_taken);
        self.messages.news(format!("Remembered as {name}"));
        let camera = scene.camera;
        scene.bookmarks.push(Bookmark { name, camera });
    }

    /// Goes to the camera that is so many places after the present one among those remembered, round and round; to the first or last
    /// where the present one is none of them.
    pub(super) fn go_to_next_bookmark(&mut self, step: isize) {
        let scene = &mut self.document.scene;
        let mut cameras = scene.bookmarks.iter().map(|bookmark| bookmark.camera);
        let present = cameras.position(|camera| camera == scene.camera);
        let count = scene.bookmarks.len();
        let start = match present {
            Some(index) => index.cast_signed() + step,
            None if step > 0 => 0,
            None => -1,
        };
        let index = start.rem_euclid(count.cast_signed().max(1)).cast_unsigned();
        if let Some(bookmark) = scene.bookmarks.get(index) {
            scene.camera = bookmark.camera;
            self.messages.news(bookmark.name.clone());
            self.show_camera_view();
        }
    }
}
