// Colour maps that people with any colour vision read in the same order, as 256 RGB triples.

export const COLOUR_MAPS = ['viridis', 'cividis', 'magma', 'greys'] as const
export type ColourMap = (typeof COLOUR_MAPS)[number]

/** 33 colours at equal steps of each map (matplotlib's own values); linear in between. */
const ANCHORS: Record<ColourMap, string> = {
  viridis:
    '440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e21918c1f988b1fa08822a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83eaddc30c2df23d8e219ece51bfde725',
  cividis:
    '00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a716f70737676767d7c788482798c8878938e789b9476a39a74aba072b4a76fbcae6cc4b468cdbb63d5c25edec958e7d150f0d846f9e03afee838',
  magma:
    '0000040303120a0822130d341d114729115a36106b440f7651127c5d177f6a1c81762181832681902a819c2e7faa337db73779c43c75d0416fdc4869e75263ef5d5ef56b5cf9795dfc8961fd9869fea772feb67cfec488fed395fde2a3fcf0b2fcfdbf',
  greys:
    'fffffffbfbfbf7f7f7f4f4f4f0f0f0eaeaeae4e4e4dfdfdfd9d9d9d2d2d2cbcbcbc4c4c4bdbdbdb3b3b3a9a9a99f9f9f9595958d8d8d8484847b7b7b7272726a6a6a6262625a5a5a5151514646463a3a3a2f2f2f2424241b1b1b111111080808000000',
}

const made = new Map<ColourMap, Uint8Array>()

/** 256 RGB triples, lowest value first. */
export function colourTable(name: ColourMap): Uint8Array {
  const known = made.get(name)
  if (known) return known
  const table = interpolated(ANCHORS[name])
  made.set(name, table)
  return table
}

function interpolated(hex: string): Uint8Array {
  const anchors = hex.length / 6
  const table = new Uint8Array(256 * 3)
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (anchors - 1)
    const low = Math.min(Math.floor(place), anchors - 2)
    for (let part = 0; part < 3; part++) {
      const from = channel(hex, low, part)
      const to = channel(hex, low + 1, part)
      table[i * 3 + part] = Math.round(from + (to - from) * (place - low))
    }
  }
  return table
}

function channel(hex: string, anchor: number, part: number): number {
  return parseInt(hex.slice(anchor * 6 + part * 2, anchor * 6 + part * 2 + 2), 16)
}

/** A colour of a map as CSS, for a share between 0 and 1. */
export function cssColour(name: ColourMap, share: number): string {
  const at = Math.round(Math.min(1, Math.max(0, share)) * 255) * 3
  const table = colourTable(name)
  return `rgb(${table[at] ?? 0}, ${table[at + 1] ?? 0}, ${table[at + 2] ?? 0})`
}
