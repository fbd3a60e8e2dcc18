// How much taller than wide a cell of a map is, from where its columns and rows lie.

/** 1 where nobody can tell; never more than 8 times one way or the other. */
export function cellAspect(x: readonly number[], y: readonly number[]): number {
  const [across, up] = [pitch(x), pitch(y)]
  return across && up ? Math.min(8, Math.max(0.125, up / across)) : 1
}

function pitch(places: readonly number[]): number {
  return places.length > 1 ? ((places.at(-1) ?? 0) - (places[0] ?? 0)) / (places.length - 1) : 0
}
