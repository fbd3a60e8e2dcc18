// What screen readers read aloud: the newest text, at most once in so many seconds.

export const EVERY_MS = 5000

/** Calls `say` at once after enough silence, otherwise later with the newest text. */
export class Announcer {
  private last = -Infinity
  private waiting: ReturnType<typeof setTimeout> | undefined
  private words = ''

  constructor(private readonly say: (words: string) => void, private readonly everyMs = EVERY_MS) {}

  tell(words: string, now = Date.now()): void {
    if (words === this.words) return
    this.words = words
    const wait = this.last + this.everyMs - now
    if (wait <= 0) this.speak(now)
    else this.waiting ??= setTimeout(() => this.speak(Date.now()), wait)
  }

  close(): void {
    clearTimeout(this.waiting)
    this.waiting = undefined
  }

  private speak(now: number): void {
    this.close()
    this.last = now
    this.say(this.words)
  }
}
