//! The files opened or saved last, newest first, as a JSON list of paths.

use std::io;
use std::path::{Path, PathBuf};

use super::lock_shared;
use crate::io::write_atomically;

/// Files that are remembered.
pub const MOST_RECENT: usize = 10;
const FILE: &str = "recent.json";

/// The list in `data`; empty where there is none that can be read.
#[must_use]
pub fn load_recent(data: &Path) -> Vec<PathBuf> {
    let text = std::fs::read_to_string(data.join(FILE)).unwrap_or_default();
    let mut paths: Vec<PathBuf> = serde_json::from_str(&text).unwrap_or_default();
    paths.truncate(MOST_RECENT);
    paths
}

/// Puts `newest` at the head of the list in `data`, where other windows may have changed it since, or empties it where there is
/// none. Returns the list.
///
/// # Errors
/// What the system says.
pub fn save_recent(data: &Path, newest: Option<&Path>) -> io::Result<Vec<PathBuf>> {
    let lock = lock_shared(data)?;
    let mut paths = Vec::new();
    if let Some(newest) = newest {
        paths = load_recent(data);
        paths.retain(|path| path != newest);
        paths.insert(0, newest.to_owned());
        paths.truncate(MOST_RECENT);
    }
    let text = serde_json::to_string_pretty(&paths)?;
    write_atomically(&data.join(FILE), |file| file.write_all(text.as_bytes()))?;
    drop(lock);
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_file_comes_first_and_none_twice() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        assert!(load_recent(data).is_empty());
        for number in 0..MOST_RECENT + 2 {
            save_recent(data, Some(&PathBuf::from(format!("/{number}.off")))).unwrap();
        }
        let again = Path::new("/5.off");
        let paths = save_recent(data, Some(again)).unwrap();
        assert_eq!(paths.len(), MOST_RECENT);
        assert_eq!(paths[..2], [again, Path::new("/11.off")]);
        assert_eq!(load_recent(data), paths);
        assert!(save_recent(data, None).unwrap().is_empty());
        std::fs::write(data.join(FILE), "no list").unwrap();
        assert!(load_recent(data).is_empty());
    }
}
