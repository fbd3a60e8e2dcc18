// Journeys: what a person does, in a real browser, against a real `labrun web --demo`.
import { defineConfig } from 'vitest/config'

export default defineConfig({
  test: {
    include: ['journeys/**/*.test.ts'],
    environment: 'node',
    tags: [{ name: 'soak', description: 'a sibling of one that CI walks, or walked for minutes: by hand, with .ci/soak' }],
    testTimeout: 300_000,
    hookTimeout: 300_000,
    // What a person would wait for; a machine that is busy shows it later, not otherwise.
    expect: { poll: { timeout: 90_000, interval: 200 } },
    fileParallelism: false,
    sequence: { concurrent: false },
  },
})
