//! The groups of a meshed model, their elements and nodes.

use std::collections::{BTreeMap, BTreeSet};

use super::extract::{self, Block, Extract, Group, Origin, WHOLE};
use super::ffi::Session;
use super::ffi_types::FfiError;

/// The groups and their nodes; `is_whole`: all surfaces are one more group, [`WHOLE`].
pub(super) fn gather(session: &Session, is_whole: bool) -> Result<Extract, FfiError> {
    let mut entity_counts = [0; 4];
    for (dimension, count) in (0..).zip(&mut entity_counts) {
        *count = session.entities(dimension)?.len();
    }
    let mut tags = session.groups()?;
    tags.sort_unstable();
    let mut groups = Vec::new();
    for (dimension, tag) in tags {
        let entities = session.group_entities(dimension, tag)?;
        let name = session.group_name(dimension, tag)?;
        groups.push(gather_group(session, (dimension, tag), name, entities)?);
    }
    if is_whole {
        let surfaces = session.entities(2)?;
        groups.push(gather_group(session, (2, 0), WHOLE.to_owned(), surfaces)?);
    }
    let nodes = number_nodes(session, &mut groups)?;
    Ok(Extract {
        origin: Origin {
            program: "Gmsh".to_owned(),
            version: session.version()?,
        },
        warnings: Vec::new(),
        parameters: BTreeMap::new(),
        entity_counts,
        nodes,
        groups,
        element_numbers: Vec::new(),
    })
}

/// A group of geometrical entities, its nodes still under Gmsh's tags.
fn gather_group(
    session: &Session,
    (dimension, tag): (i32, i32),
    name: String,
    mut entities: Vec<i32>,
) -> Result<Group, FfiError> {
    entities
        .iter_mut()
        .for_each(|entity| *entity = entity.abs());
    entities.sort_unstable();
    entities.dedup();
    let mut elements: BTreeMap<i32, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
    let mut properties = BTreeMap::new();
    for entity in entities {
        for block in session.elements(dimension, entity)? {
            let property = session.element_properties(block.kind)?;
            let nodes = block.nodes.chunks_exact(property.node_count.max(1));
            let members = elements.entry(block.kind).or_default();
            members.extend(block.tags.into_iter().zip(nodes.map(<[usize]>::to_vec)));
            properties.insert(block.kind, property);
        }
    }
    let blocks = elements.into_iter().zip(properties.into_values());
    Ok(Group {
        dimension: extract::dimension(dimension),
        tag,
        name,
        blocks: blocks
            .map(|((kind, members), property)| Block {
                kind,
                kind_name: property.name,
                order: property.order,
                nodes_per_element: property.node_count,
                tags: members.keys().map(|&tag| tag as u64).collect(),
                nodes: members.into_values().flatten().collect(),
            })
            .collect(),
    })
}

/// Replaces node tags by indices into the positions returned: the used nodes, ascending by tag.
fn number_nodes(session: &Session, groups: &mut [Group]) -> Result<Vec<[f64; 3]>, FfiError> {
    let used: BTreeSet<usize> = groups
        .iter()
        .flat_map(|group| &group.blocks)
        .flat_map(|block| block.nodes.iter().copied())
        .collect();
    let mut nodes = session.nodes()?;
    nodes.retain(|(tag, _)| used.contains(tag));
    nodes.sort_by_key(|(tag, _)| *tag);
    nodes.dedup_by_key(|(tag, _)| *tag);
    for block in groups.iter_mut().flat_map(|group| &mut group.blocks) {
        for node in &mut block.nodes {
            *node = nodes
                .binary_search_by_key(node, |(tag, _)| *tag)
                .map_err(|_| FfiError::NodeMissing { node: *node })?;
        }
    }
    Ok(nodes.into_iter().map(|(_, position)| position).collect())
}
