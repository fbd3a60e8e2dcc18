// How the page is built: into app-dist, packed ahead for the server, with no script inside the HTML.
import vue from '@vitejs/plugin-vue'
import { defineConfig } from 'vitest/config'
import { packed } from './scripts/packed.mjs'

export default defineConfig({
  plugins: [vue(), packed()],
  define: { __VUE_OPTIONS_API__: 'false', __VUE_PROD_DEVTOOLS__: 'false' },
  build: {
    outDir: 'app-dist',
    emptyOutDir: true,
    target: 'es2022',
    sourcemap: false,
    assetsInlineLimit: 0,
    cssCodeSplit: false, // one small sheet packs better than forty
    modulePreload: { polyfill: false },
    // So do the small modules that several screens share, and those that several parts of the editor do.
    rolldownOptions: {
      output: {
        codeSplitting: {
          groups: [
            { name: 'shared', test: /src.(ui|api|app|protocols.text.(path|write)|(runs|devices|protocols).\w+\.ts)/, minShareCount: 2 },
            { name: 'protocol', test: /src.protocols.(text|editor).(?!fields)[a-z]/, minShareCount: 2 },
          ],
        },
      },
    },
  },
  server: {
    port: 5173,
    proxy: {
      '/api': process.env['LABRUN_WEB'] ?? 'http://127.0.0.1:8321',
      '/socket.io': { target: process.env['LABRUN_WEB'] ?? 'http://127.0.0.1:8321', ws: true },
    },
  },
  test: {
    environment: 'happy-dom',
    include: ['src/**/*.test.ts'],
    testTimeout: 20_000,
    restoreMocks: true,
    isolate: false, // a window for each file costs four times the tests themselves
  },
})
