//! Relative paths in serialised composites.

/// Returns `path` relative to the directory of the file `root`.
pub fn beside(root: &str, path: &str) -> String {
    let mut folder: Vec<&str> = root.split('/').collect();
    folder.pop();
    let parts: Vec<&str> = path.split('/').collect();
    let is_absolute = |parts: &[&str]| parts.first().is_some_and(|first| first.is_empty());
    if is_absolute(&parts) != is_absolute(&folder) {
        return path.to_owned();
    }
    let pairs = folder.iter().zip(&parts);
    let common = pairs.take_while(|(one, other)| one == other).count();
    let up = std::iter::repeat_n("..", folder.len() - common);
    let down = parts.iter().skip(common).copied();
    up.chain(down).collect::<Vec<_>>().join("/")
}
