//! Folds boxes and frames that differ only in a number, as the instances of one element of a composite do, into one.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_plan::{MANY_NUMBERED, NumberedName};

use crate::picture::{CompositeFrame, EdgeEnd, EdgeKind, Picture, PictureEdge, PictureNode};

/// Replaces boxes in one frame whose names differ only in their first number, and frames with the same contents, by the first of them.
///
/// Boxes are folded only if they have the same ports, implementation and process, and are connected in the same way: to the same boxes,
/// or to boxes that are folded as well.
pub(crate) fn folded(picture: Picture) -> Picture {
    let families = Families::of(&picture);
    let folds = Folds::of(&picture, &families);
    folds.apply(picture)
}

/// Number of a family.
type Family = usize;

/// Frames and boxes that are equal except for numbers, as far as the picture goes: with equal contents and connections.
struct Families {
    frames: Vec<Family>,
    nodes: Vec<Family>,
}

impl Families {
    /// Begins with names and ports, and splits families until the members of each have the same neighbours.
    fn of(picture: &Picture) -> Self {
        let mut families = Self {
            frames: vec![0; picture.frames.len()],
            nodes: vec![0; picture.nodes.len()],
        };
        let mut count = 0;
        loop {
            families = families.split(picture);
            // a family is never merged with another one, so an equal number of them means the same families
            let found = families.count();
            if found == count {
                return families;
            }
            count = found;
        }
    }

    fn count(&self) -> usize {
        let distinct = |of: &[Family]| of.iter().collect::<BTreeSet<_>>().len();
        distinct(&self.frames) + distinct(&self.nodes)
    }

    /// The families whose members agree in their own family and in those of their neighbours.
    fn split(&self, picture: &Picture) -> Self {
        let mut contents = vec![BTreeMap::<(bool, Family), usize>::new(); picture.frames.len()];
        for (frame, family) in picture.frames.iter().zip(&self.frames) {
            if let Some(inside) = frame.parent.and_then(|it| contents.get_mut(it)) {
                *inside.entry((true, *family)).or_default() += 1;
            }
        }
        for (node, family) in picture.nodes.iter().zip(&self.nodes) {
            if let Some(inside) = contents.get_mut(node.frame) {
                *inside.entry((false, *family)).or_default() += 1;
            }
        }
        let frames = picture.frames.iter().zip(&self.frames).zip(contents);
        let frames = frames.map(|((frame, family), contents)| {
            let parent = frame.parent.map(|it| self.frames.get(it).copied());
            (pattern(&frame.name), parent, *family, contents)
        });
        let mut neighbours = vec![BTreeSet::new(); picture.nodes.len()];
        for PictureEdge { from, to, kind } in &picture.edges {
            for (end, other, leaves) in [(from, to, true), (to, from, false)] {
                let family = self.nodes.get(other.node).copied();
                if let Some(all) = neighbours.get_mut(end.node) {
                    all.insert((
                        leaves,
                        end.port,
                        family,
                        other.port,
                        *kind == EdgeKind::Call,
                    ));
                }
            }
        }
        let nodes = picture.nodes.iter().zip(&self.nodes).zip(neighbours);
        let nodes = nodes.map(|((node, family), neighbours)| {
            let frame = self.frames.get(node.frame).copied();
            (looks(node), frame, *family, neighbours)
        });
        Self {
            frames: numbered_in_order(frames),
            nodes: numbered_in_order(nodes),
        }
    }
}

/// What is drawn of a box, without its number.
fn looks(node: &PictureNode) -> impl Ord + use<> {
    let ports = [&node.left, &node.right].map(|ports| {
        let ports = ports.iter().map(|it| (it.name.clone(), it.service));
        ports.collect::<Vec<_>>()
    });
    let (name, note) = (pattern(&node.name), node.note.clone());
    (node.kind as u8, name, note, node.process, ports)
}

/// Gives equal keys equal numbers.
fn numbered_in_order<K: Ord>(keys: impl Iterator<Item = K>) -> Vec<Family> {
    let mut known = BTreeMap::new();
    let numbers = keys.map(|key| {
        let next = known.len();
        *known.entry(key).or_insert(next)
    });
    numbers.collect()
}

/// The frame and the box that is drawn for each.
struct Folds {
    frames: Vec<usize>,
    nodes: Vec<usize>,
    /// Names of those that stand for several.
    frame_names: BTreeMap<usize, String>,
    node_names: BTreeMap<usize, String>,
}

impl Folds {
    fn of(picture: &Picture, families: &Families) -> Self {
        let frames: Vec<Member<'_>> = picture
            .frames
            .iter()
            .zip(&families.frames)
            .map(|(frame, family)| Member {
                parent: frame.parent,
                family: *family,
                name: &frame.name,
            })
            .collect();
        // a frame comes after the one that contains it
        let mut drawn_frames = Vec::with_capacity(frames.len());
        let groups = Groups::of(&frames);
        for index in 0..frames.len() {
            let drawn = groups.drawn(&frames, index, &drawn_frames);
            drawn_frames.push(drawn);
        }
        let frame_names = groups.names(&frames).collect();
        let nodes: Vec<Member<'_>> = picture
            .nodes
            .iter()
            .zip(&families.nodes)
            .map(|(node, family)| Member {
                parent: Some(node.frame),
                family: *family,
                name: &node.name,
            })
            .collect();
        let groups = Groups::of(&nodes);
        let drawn_nodes = (0..nodes.len()).map(|it| groups.drawn(&nodes, it, &drawn_frames));
        let drawn_nodes = drawn_nodes.collect();
        Self {
            frames: drawn_frames,
            nodes: drawn_nodes,
            node_names: groups.names(&nodes).collect(),
            frame_names,
        }
    }

    /// Leaves out what is not drawn.
    fn apply(self, picture: Picture) -> Picture {
        let (frames, frame_places) = drawn(picture.frames, &self.frames);
        let (nodes, node_places) = drawn(picture.nodes, &self.nodes);
        let place = |of: usize, drawn: &[usize], places: &BTreeMap<usize, usize>| {
            let drawn = drawn.get(of)?;
            places.get(drawn).copied()
        };
        let frames = frames.into_iter().map(|(index, frame)| CompositeFrame {
            name: self.frame_names.get(&index).cloned().unwrap_or(frame.name),
            parent: frame
                .parent
                .and_then(|it| place(it, &self.frames, &frame_places)),
        });
        let nodes = nodes.into_iter().map(|(index, node)| PictureNode {
            name: self.node_names.get(&index).cloned().unwrap_or(node.name),
            frame: place(node.frame, &self.frames, &frame_places).unwrap_or_default(),
            ..node
        });
        let end = |end: EdgeEnd| {
            let node = place(end.node, &self.nodes, &node_places)?;
            Some(EdgeEnd { node, ..end })
        };
        let mut edges: Vec<PictureEdge> = Vec::new();
        let mut known = BTreeSet::new();
        for PictureEdge { from, to, kind } in picture.edges {
            let (Some(from), Some(to)) = (end(from), end(to)) else {
                continue;
            };
            if known.insert((
                from.node,
                from.port,
                to.node,
                to.port,
                kind == EdgeKind::Call,
            )) {
                edges.push(PictureEdge { from, to, kind });
            }
        }
        Picture {
            frames: frames.collect(),
            nodes: nodes.collect(),
            edges,
            processes: picture.processes,
        }
    }
}

/// The items that are drawn, with their positions among all, and the positions of those among the drawn ones.
fn drawn<T>(items: Vec<T>, drawn: &[usize]) -> (Vec<(usize, T)>, BTreeMap<usize, usize>) {
    let items = items.into_iter().enumerate().zip(drawn);
    let kept = items.filter(|((index, _), drawn)| index == *drawn);
    let kept: Vec<_> = kept.map(|(item, _)| item).collect();
    let places = kept.iter().enumerate();
    let places = places.map(|(place, (index, _))| (*index, place)).collect();
    (kept, places)
}

/// A frame or a box.
struct Member<'p> {
    /// The frame that contains it; `None` for the outermost.
    parent: Option<usize>,
    family: Family,
    name: &'p str,
}

/// The members of each family in each frame, and which of them are folded.
struct Groups(BTreeMap<(Option<usize>, Family), Vec<usize>>);

impl Groups {
    fn of(members: &[Member<'_>]) -> Self {
        let mut groups: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for (index, member) in members.iter().enumerate() {
            let key = (member.parent, member.family);
            groups.entry(key).or_default().push(index);
        }
        Self(groups)
    }

    /// The member that is drawn for this one: itself, the first of its group if the group is folded, or the one that stands in its
    /// place in the frame that is drawn for its frame.
    fn drawn(&self, members: &[Member<'_>], index: usize, frames: &[usize]) -> usize {
        let Some(member) = members.get(index) else {
            return index;
        };
        let parent = member
            .parent
            .map(|it| frames.get(it).copied().unwrap_or(it));
        let group = self.0.get(&(parent, member.family));
        let group = group.map_or(&[][..], Vec::as_slice);
        let first = group.first().copied().unwrap_or(index);
        if is_folded(group, members) {
            return first;
        }
        if parent == member.parent {
            return index;
        }
        let named = |it: &&usize| members.get(**it).is_some_and(|it| it.name == member.name);
        let same = group.iter().find(named).copied();
        // the number of its frame may be part of its name
        let own = self.0.get(&(member.parent, member.family));
        let place = own.and_then(|own| own.iter().position(|it| *it == index));
        let in_place = place.and_then(|place| group.get(place).copied());
        same.or(in_place).unwrap_or(first)
    }

    /// The names of members that stand for their groups.
    fn names<'g>(
        &'g self,
        members: &'g [Member<'_>],
    ) -> impl Iterator<Item = (usize, String)> + 'g {
        let folded = self.0.values().filter(|it| is_folded(it, members));
        folded.filter_map(|group| {
            let name = |it: &usize| members.get(*it).map(|it| it.name);
            let first = *group.first()?;
            let numbered = NumberedName::of(name(&first)?)?;
            let numbers = group.iter();
            let numbers = numbers.filter_map(|it| NumberedName::of(name(it)?)?.number());
            let range = (numbers.clone().min()?, numbers.max()?);
            let (range, count) = (numbered.of_range(range), group.len());
            Some((first, format!("{range} ×{count}")))
        })
    }
}

/// Returns whether the members of a group are many, and have numbers.
fn is_folded(group: &[usize], members: &[Member<'_>]) -> bool {
    let first = group.first().and_then(|it| members.get(*it));
    group.len() >= MANY_NUMBERED && first.is_some_and(|it| NumberedName::of(it.name).is_some())
}

/// A name without its first number, which distinguishes it from one that never had one.
fn pattern(name: &str) -> (String, Option<String>) {
    match NumberedName::of(name) {
        Some(NumberedName { before, after, .. }) => (before.to_owned(), Some(after.to_owned())),
        None => (name.to_owned(), None),
    }
}
