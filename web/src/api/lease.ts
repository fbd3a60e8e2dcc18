// The secret that proves who has control: kept for this tab alone, also over a reload.
const KEY = 'labrun.lease'

/** The lease that this tab holds, or held last; null where it never did. */
export function keptLease(): string | null {
  return sessionStorage.getItem(KEY)
}

/** Keep a lease; null forgets it. */
export function keepLease(lease: string | null): void {
  if (lease === null) sessionStorage.removeItem(KEY)
  else sessionStorage.setItem(KEY, lease)
}
