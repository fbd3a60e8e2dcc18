// Height over width of a map's cell, from the positions of its columns and rows.

/** 1 if unknown; at most 8 times either way. */
export function cellAspect(x: readonly number[], y: readonly number[]): number {
  const [across, up] = [pitch(x), pitch(y)]
  return across && up ? Math.min(8, Math.max(0.125, up / across)) : 1
}

function pitch(places: readonly number[]): number {
  return places.length > 1 ? ((places.at(-1) ?? 0) - (places[0] ?? 0)) / (places.length - 1) : 0
}
