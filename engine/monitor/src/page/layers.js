// @ts-check
// Places nodes in layers: each below those that lead to it, and in a layer near those it is joined to.

/** @param {string[]} nodes @param {[string, string][]} edges @param {string[]} [first] nodes of the first layer
 * @returns {Map<string, { layer: number, place: number }>} */
export function layers(nodes, edges, first = []) {
  const layer = new Map();
  const next = new Map(nodes.map((node) => [node, []]));
  const entering = new Map(nodes.map((node) => [node, 0]));
  for (const [from, to] of edges) {
    if (from === to || !next.has(from) || !next.has(to)) continue;
    next.get(from).push(to);
    entering.set(to, entering.get(to) + 1);
  }
  const roots = first.length ? first : nodes.filter((node) => entering.get(node) === 0);
  // breadth first, so that a cycle does not push a node down for ever
  let front = roots.length ? roots : nodes.slice(0, 1);
  front.forEach((node) => layer.set(node, 0));
  for (let depth = 1; front.length; depth++) {
    const found = [...new Set(front.flatMap((node) => next.get(node) ?? []))].filter((node) => !layer.has(node));
    found.forEach((node) => layer.set(node, depth));
    front = found;
    if (!front.length) {
      const left = nodes.find((node) => !layer.has(node));
      if (left) { depth = 0; layer.set(left, depth); front = [left]; }
    }
  }
  const rows = [];
  for (const node of nodes) (rows[layer.get(node)] ??= []).push(node);
  const placed = new Map();
  const sort = (row, neighbours) => {
    const weight = new Map(row.map((node, index) => {
      const places = neighbours(node).map((it) => placed.get(it)?.place).filter((it) => it !== undefined);
      return [node, places.length ? places.reduce((sum, it) => sum + it, 0) / places.length : index / row.length];
    }));
    row.sort((one, other) => weight.get(one) - weight.get(other));
    row.forEach((node, index) => placed.set(node, { layer: layer.get(node), place: (index + 0.5) / row.length }));
  };
  const before = (node) => edges.filter(([, to]) => to === node).map(([from]) => from);
  const after = (node) => edges.filter(([from]) => from === node).map(([, to]) => to);
  const filled = rows.filter(Boolean);
  for (let pass = 0; pass < 4; pass++) {
    filled.forEach((row) => sort(row, before));
    [...filled].reverse().forEach((row) => sort(row, after));
  }
  return placed;
}
