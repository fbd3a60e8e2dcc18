// Light, dark or same as the system; and lab mode, which keeps the screen awake.
import { onScopeDispose, watchEffect, ref } from 'vue'
import { usePreferences } from './preferences'

/** Put theme and lab mode on the document, while the calling scope lives. */
export function useTheme(): void {
  const preferences = usePreferences()
  const system = matchMedia('(prefers-color-scheme: dark)')
  const dark = ref(system.matches)
  const changed = (event: MediaQueryListEvent) => (dark.value = event.matches)
  system.addEventListener('change', changed)
  onScopeDispose(() => system.removeEventListener('change', changed))

  watchEffect(() => {
    const wanted = preferences.theme === 'system' ? (dark.value ? 'dark' : 'light') : preferences.theme
    document.documentElement.dataset['theme'] = wanted
    document.documentElement.toggleAttribute('data-lab', preferences.lab)
  })
  keepAwake(() => preferences.lab)
}

/** A screen lock is lost when the page is hidden, so it is requested again when the page is visible. */
function keepAwake(wanted: () => boolean): void {
  let lock: WakeLockSentinel | null = null
  async function ask(): Promise<void> {
    if (!wanted() || document.hidden || !('wakeLock' in navigator)) return
    // Refused on a low battery: the screen then turns off as usual.
    lock = await navigator.wakeLock.request('screen').catch(() => null)
  }
  const seen = () => void ask()
  document.addEventListener('visibilitychange', seen)
  onScopeDispose(() => {
    document.removeEventListener('visibilitychange', seen)
    void lock?.release()
  })
  watchEffect(() => {
    if (wanted()) void ask()
    else void lock?.release()
  })
}
