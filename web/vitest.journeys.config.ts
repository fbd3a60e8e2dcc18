// Journeys: what a person does, in a real browser, against a real `labrun web --demo`.
import { defineConfig } from 'vitest/config'

export default defineConfig({
  test: {
    include: ['journeys/**/*.test.ts'],
    environment: 'node',
    testTimeout: 120_000,
    hookTimeout: 120_000,
    // What a person would wait for; a machine that is busy shows it later, not otherwise.
    expect: { poll: { timeout: 30_000 } },
    fileParallelism: false,
    // A jog must be kept alive ten times a second: a machine that stalls ends it, and so it should.
    retry: 1,
    sequence: { concurrent: false },
  },
})
