// Tells the part's feature lines from the crumbs that slivers of its mesh leave. Numbers only.

/**
 * Of segments (x, y, z, x, y, z each), those whose connected line is at least `least` long in all. Segments connect
 * where their ends coincide to a tenth of a millimetre.
 */
export function longLines(segments: Float32Array, least: number): Float32Array<ArrayBuffer> {
    const corners = new Map<string, number>();
    const parent: number[] = [];
    const root = (node: number): number => {
        let top = node;
        while (parent[top] !== top) top = parent[top] ?? top;
        parent[node] = top;
        return top;
    };
    const corner = (at: number): number => {
        const key = [0, 1, 2].map((axis) => Math.round((segments[at + axis] ?? 0) * 1e4)).join();
        let node = corners.get(key);
        if (node === undefined) {
            node = parent.length;
            parent.push(node);
            corners.set(key, node);
        }
        return node;
    };
    const count = Math.floor(segments.length / 6);
    const starts: number[] = [];
    for (let i = 0; i < count; ++i) {
        const start = corner(6 * i);
        starts.push(start);
        parent[root(corner(6 * i + 3))] = root(start);
    }
    const lengths = new Map<number, number>();
    for (let i = 0; i < count; ++i) {
        const along = [0, 1, 2].map((axis) => (segments[6 * i + 3 + axis] ?? 0) - (segments[6 * i + axis] ?? 0));
        const line = root(starts[i] ?? 0);
        lengths.set(line, (lengths.get(line) ?? 0) + Math.hypot(...along));
    }
    const kept: number[] = [];
    for (let i = 0; i < count; ++i)
        if ((lengths.get(root(starts[i] ?? 0)) ?? 0) >= least) kept.push(...segments.subarray(6 * i, 6 * i + 6));
    return new Float32Array(kept);
}
