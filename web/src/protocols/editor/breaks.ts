// Line breaks as the file has them: the editor works with \n, and saving gives back the file's own.

export interface Breaks {
  text: string
  restore(text: string): string
}

/** If every line ends in \r\n, so does every saved line; a mixture is kept as it is. */
export function withoutBreaks(text: string): Breaks {
  const windows = text.includes('\r\n') && !/(^|[^\r])\n|\r(?!\n)/.test(text)
  if (!windows) return { text, restore: (now) => now }
  return { text: text.replaceAll('\r\n', '\n'), restore: (now) => now.replaceAll('\n', '\r\n') }
}
