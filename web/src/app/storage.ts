// A browser that keeps nothing for this page, as with all cookies blocked, refuses the very question: what is kept then lasts as long as the page.
for (const name of ['localStorage', 'sessionStorage'] as const) {
  try {
    void window[name].length
  } catch {
    const kept = new Map<string, string>()
    const value = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, text: string) => void kept.set(key, text), removeItem: (key: string) => void kept.delete(key) }
    Object.defineProperty(window, name, { value })
  }
}

export {}
